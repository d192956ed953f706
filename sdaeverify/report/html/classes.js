// Verdicts on claims about classes of equations, and the trees of conditions that fail.

const CLASS_ROWS = records(DATA.classes || {});
const LEAF = 34, STOREY = 40, RADIUS = 13;

/** Return what order conditions say of a scheme: a table, and a drawing of each first condition that refutes a claim. */
function classesOf(name) {
  const own = CLASS_ROWS.filter((row) => row.scheme === name);
  if (!own.length) return [];
  const rows = own.map((row) => [row.class, row.motions, row.measure, row.claim, short(row.order, 3), row.of ? `${row.held} of ${row.of}` : "", badge(row.verdict), row.reason || row.premise]);
  const failing = [...grouped(own.filter((row) => row.verdict === "refuted" && row.first), (row) => row.first).values()];
  return [heading(2, "Classes of equations"), el("p", { class: "soft" }, "Order conditions come from one step on an equation whose components are rooted trees, and hold for every smooth equation of a class with at most as many Brownian motions as given here. Classes named after a form are tested on random members."),
    table(["class", "motions", "measure", "claim", "order", "conditions or members held", "", "why"], rows, { class: "blocks" }),
    el("div", { class: "cards" }, failing.map((same) => el("article", { class: "card" }, el("h3", {}, conditionText(same[0])), forestPicture(same[0].first), el("p", { class: "soft" }, `${same[0].measure}; classes ${same.map((row) => row.class).join(", ")}`), command(same[0]))))];
}

/** Return the page of a run that has verdicts on classes only. */
function classesPage() {
  const schemes = [...new Set(CLASS_ROWS.map((row) => row.scheme))];
  return ["Classes of equations", heading(1, "Classes of equations"), ...schemes.flatMap((name) => [heading(2, name), ...classesOf(name).slice(1)])];
}

const conditionText = (row) => `${row.first}: found ${row.found}, wanted ${row.wanted}`;

/** Return the equations that a scheme solves to one order more, each with the trees of its terms folded away. */
function equationsOf(name) {
  const own = CLASS_ROWS.filter((row) => row.scheme === name && row.modified);
  if (!own.length) return [];
  const card = (same) => {
    const [first, ...lines] = linesOf(same[0].modified), terms = linesOf(same[0].modified_terms);
    const classes = unique(same.map((row) => row.class)).join(", ");
    return el("article", { class: "card" }, el("h3", {}, `${classes}: ${first.slice(first.indexOf(": ") + 2)}`),
      lines.length ? el("pre", { class: "formula" }, lines.map((line) => line.trim()).join("\n")) : null,
      terms.length ? el("details", {}, el("summary", {}, "its terms as trees"), el("div", { class: "terms" }, terms.map(termFigure))) : null);
  };
  return [heading(2, "Modified equations"), el("p", { class: "soft" }, "The equation that the scheme solves to one order more in the weak sense: its leading errors, or what a refuted scheme does instead."),
    el("div", { class: "cards equations" }, [...grouped(own, (row) => row.modified_terms || row.modified).values()].map(card))];
}

const linesOf = (text) => (text ? text.replaceAll("\\n", "\n").split("\n") : []);

/** Return a figure of the trees of a line "trees: formula". */
function termFigure(line) {
  const place = line.indexOf(": ");
  return el("figure", {}, forestPicture(line.slice(0, place)), el("figcaption", {}, line.slice(place + 2)));
}

/** Return the trees of a formula such as "b1(t,b2) . f". */
function treesOf(formula) {
  let place = 0;
  const node = () => {
    const begin = place;
    while (place < formula.length && !"(,)".includes(formula[place])) place += 1;
    const tree = { name: formula.slice(begin, place).trim(), kids: [] };
    if (formula[place] !== "(") return tree;
    while (formula[place] === "(" || formula[place] === ",") {
      place += 1;
      tree.kids.push(node());
    }
    place += 1;
    return tree;
  };
  return formula.split(" . ").map((part) => {
    [formula, place] = [part, 0];
    return node();
  });
}

const leaves = (tree) => (tree.kids.length ? tree.kids.reduce((sum, kid) => sum + leaves(kid), 0) : 1);
const storeys = (tree) => 1 + Math.max(0, ...tree.kids.map(storeys));

/** Draw a forest, each root below: the drift full, noise hollow, time without a circle. */
function forestPicture(formula) {
  const trees = treesOf(formula), height = STOREY * Math.max(...trees.map(storeys)) + 8;
  const width = LEAF * trees.reduce((sum, tree) => sum + leaves(tree), 0) + 24 * (trees.length - 1) + 8;
  const parts = [];
  let left = 4;
  for (const tree of trees) {
    drawTree(tree, left, height - STOREY / 2, parts);
    left += LEAF * leaves(tree) + 24;
  }
  return el("svg", { viewBox: `0 0 ${width} ${height}`, width, height, role: "img", "aria-label": `trees ${formula}` }, parts);
}

/** Draw a tree from a left edge on, and return where its root is. */
function drawTree(tree, left, y, parts) {
  let from = left;
  const above = tree.kids.map((kid) => {
    const x = drawTree(kid, from, y - STOREY, parts);
    from += LEAF * leaves(kid);
    return x;
  });
  const x = above.length ? (above[0] + above[above.length - 1]) / 2 : left + LEAF / 2;
  parts.unshift(...above.map((end) => el("line", { class: "axis", x1: x, y1: y, x2: end, y2: y - STOREY })));
  const kind = tree.name === "t" ? "time" : tree.name.startsWith("b") ? "noise" : "drift";
  parts.push(el("circle", { class: `node ${kind}`, cx: x, cy: y, r: RADIUS }), el("text", { class: `node ${kind}`, x, y: y + 4, "text-anchor": "middle" }, tree.name));
  return x;
}
