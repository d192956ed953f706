// Summary, matrix and cell.

const PARTS = DATA.parts || {}, ABOVE = DATA.above || "";
const link = (page, ...names) => fileOf(page, names) + "#/" + [page, ...names.map(encodeURIComponent)].join("/");

/** Return the file that shows a page: that of its problem in a large run, the page of the run for others; "" for this one. */
function fileOf(page, names) {
  if (ABOVE) return ["cell", "problem"].includes(page) ? "" : ABOVE;
  return PARTS[{ cell: names[1], problem: names[0] }[page]] || "";
}
const schemeLink = (name) => el("a", { href: link("scheme", name) }, name);
const problemLink = (name) => el("a", { href: link("problem", name) }, name);
const cellLink = (one, text) => el("a", { href: link("cell", one.scheme, one.problem) }, text);
const badge = (verdict) => el("span", { class: `v ${verdict}` }, `${VERDICTS[verdict][0]} ${VERDICTS[verdict][1]}`);
const heading = (level, text) => el(`h${level}`, {}, text);
const facts = (pairs) => el("dl", {}, pairs.filter(([, told]) => told !== "" && told !== null && told !== undefined && !(Array.isArray(told) && !told.length))
  .map(([name, told]) => [el("dt", {}, name), el("dd", {}, told)]));
const claimText = (one) => (!one.claim ? "none" : finite(one.claimed_order) && finite(one.margin) ? `order ≥ ${one.claimed_order.toFixed(1)} (sampled: ≥ ${short(one.claimed_order - one.margin)})` : one.claim);
/** Return the text of a claim whose aside, the order accepted along paths, is not broken. */
function claimParts(one) {
  const [claim, ...asides] = claimText(one).split(" (");
  return [claim, asides.map((aside) => [" ", el("span", { class: "together" }, `(${aside}`)])];
}

function summaryPage() {
  const open = FINDINGS.filter((one) => ATTENTION.includes(one.verdict));
  return ["Summary", heading(1, DATA.sentence), tiles(), heading(2, "What needs attention"),
    open.length ? attention(open) : el("p", {}, "Nothing is refuted, failed or inconclusive."),
    heading(2, "Schemes and measures"), el("p", { class: "soft" }, "Number of verified quantities among those with a claim; other verdicts follow."), schemesByMeasures(),
    heading(2, "What a verdict means"), meanings(), heading(2, "How it was run"), provenance()];
}

function tiles() {
  const counts = grouped(FINDINGS, (one) => one.verdict);
  const shown = Object.keys(VERDICTS).filter((verdict) => counts.has(verdict) || ["refuted", "verified", "inconclusive"].includes(verdict));
  return el("ul", { class: "tiles" }, shown.map((verdict) => el("li", counts.has(verdict) ? {} : { class: "zero" }, el("a", { href: `#/matrix?verdict=${verdict}` },
    el("b", {}, String((counts.get(verdict) || []).length)), badge(verdict)))));
}

function attention(open) {
  const groups = [...grouped(open, (one) => JSON.stringify([one.verdict, one.problem, one.measure, one.claim, one.reason.replace(/[0-9.]+/g, "")])).values()];
  groups.sort((a, b) => ATTENTION.indexOf(a[0].verdict) - ATTENTION.indexOf(b[0].verdict));
  // Measures that say the same of the same schemes, such as all those of a step that raises, are one row.
  const alike = [...grouped(groups, (group) => JSON.stringify([group[0].verdict, group[0].problem, unique(group.map((one) => one.scheme)), claimText(group[0]), found(group[0]), group[0].reason])).values()];
  const rows = alike.map((some) => {
    const first = some[0][0], cells = [...grouped(some.flat(), place).values()].map((list) => list[0]);
    const names = [cells.slice(0, 6).map((one, n) => [n ? ", " : "", cellLink(one, one.scheme)]), cells.length > 6 ? ` and ${cells.length - 6} more` : ""];
    const quantities = some.map((group) => `${group[0].measure} ${unique(group.map((one) => one.quantity)).join(", ")}`.trim());
    return [badge(first.verdict), el("span", {}, names), problemLink(first.problem), fewOf(quantities), claimParts(first), found(first), first.reason];
  });
  return table(["", "scheme", "problem", "quantity", "claim", "found", "why"], rows, { class: "reasons" });
}

/** Return the first of several measures with their quantities, and how many more there are. */
function fewOf(told) {
  const shown = told.length > 6 ? told.slice(0, 4) : told, more = told.length - shown.length;
  return shown.join(told.some((one) => one.includes(" ")) ? "; " : ", ") + (more ? ` and ${more} more` : "");
}

function schemesByMeasures() {
  const cells = grouped(FINDINGS, (one) => JSON.stringify([one.scheme, one.measure]));
  const text = (findings) => {
    const claims = findings.filter((one) => one.claim && one.verdict !== "out_of_scope"), good = claims.filter((one) => one.verdict === "verified").length;
    const rest = ATTENTION.map((verdict) => [verdict, (claims.length ? claims : findings).filter((one) => one.verdict === verdict).length]).filter(([, count]) => count);
    if (!claims.length && !rest.length) return el("span", { class: "soft" }, `○ ${findings.length}`);
    if (!claims.length) return rest.map(([verdict, count]) => el("span", { class: `v ${verdict}` }, `${VERDICTS[verdict][0]} ${count}`));
    return [`${good === claims.length ? "✓ " : ""}${good} of ${claims.length}`, rest.map(([verdict, count]) => [" ", el("span", { class: `v ${verdict}` }, `${VERDICTS[verdict][0]} ${count}`)])];
  };
  const rows = unique(FINDINGS.map((one) => one.scheme)).sort().map((scheme) => [schemeLink(scheme), ...MEASURES.map((measure) => {
    const findings = cells.get(JSON.stringify([scheme, measure]));
    return findings ? el("span", {}, text(findings)) : "";
  })]);
  return table(["scheme", ...MEASURES], rows, { class: "tight" });
}

function meanings() {
  const tiers = [["T0", "contract of a step and exactness on trivial equations"], ["T1", "one step, at cubature nodes, without sampling"],
    ["T2", "moments, transition operator, spectral radius, without sampling"], ["T3", "paths that all schemes and step sizes share"], ["TA", "order conditions: from one step, for every smooth SDE of a class; shown in addition to the other tiers, which it does not override"]];
  const verdicts = [["verified", "the cheapest tier that decides confirms the claim, and the next one does not contradict it: an order from one step of the claim up to a tolerance, or an order along paths above claim − margin"],
    ["refuted", "a contract is broken, a step does not follow the equation, or an order is significantly too low"],
    ["inconclusive", "all other cases; the reason names what would decide"],
    ["error", "not measured, because a step or a measure raised an exception, exceeded a limit or ended its process"], ["out_of_scope", "measured, but the scheme makes no claim about it"]];
  return el("div", {}, table(["", "meaning"], verdicts.map(([verdict, words]) => [badge(verdict), words])), table(["tier", "what decides"], tiers));
}

function provenance() {
  const run = DATA.run, told = run.settings || {}, steps = told.steps || [];
  return el("div", {}, facts([["command", (run.arguments || []).join(" ")], ["seed", String(run.seed ?? "")], ["steps", steps.length ? `${steps[0]} to ${steps[steps.length - 1]}` : ""],
    ["paths at most", String(told.paths ?? "")], ["confidence", `${short(told.confidence ?? null, 4)}, error level shared among ${told.tests_reserved ?? "?"} tests and ${told.max_looks ?? "?"} looks`],
    ["versions", Object.entries(run.versions || {}).map(([name, version]) => `${name} ${version}`).join(", ")], ["system", (run.platform || {}).system],
    ["fingerprint of the noise", run.stream_fingerprint], ["seconds of steps", short(seconds(FINDINGS), 4)]]),
    (run.warnings || []).length ? el("details", {}, el("summary", {}, "warnings"), el("pre", {}, run.warnings.join("\n"))) : null,
    el("details", {}, el("summary", {}, "plugins"), table(["plugin", "distribution", "version", "status", "reason"], (run.plugins || []).map((p) => [p.name, p.distribution, p.version, p.status, p.reason]))));
}

/** Return the measured seconds, each scheme on each problem once. */
function seconds(findings) {
  return [...grouped(findings, place).values()].reduce((sum, group) => sum + Math.max(0, ...group.map((one) => one.seconds || 0)), 0);
}

function matrixPage(query) {
  const chosen = { measure: "", verdict: "", form: "", text: "", ...query };
  const forms = unique(PROBLEMS.map((name) => (PASSPORTS.problems[name] || {}).form || "")).filter(Boolean).sort();
  const select = (name, label, options) => el("label", {}, label, el("select", { name, onchange: update },
    el("option", { value: "" }, "all"), options.map(([key, text]) => el("option", { value: key, selected: chosen[name] === key ? "" : null }, text))));
  const frame = el("div", { class: "wide" }), note = el("p", { class: "soft", role: "status" });
  const form = el("form", { class: "filters", onsubmit: (event) => event.preventDefault() },
    select("measure", "measure", MEASURES.map((name) => [name, name])), select("verdict", "verdict", Object.entries(VERDICTS).slice(0, -1).map(([key, [, text]]) => [key, text])),
    forms.length ? select("form", "family of problems", forms.map((name) => [name, name])) : null,
    el("label", {}, "name contains", el("input", { name: "text", type: "search", value: chosen.text, oninput: update })));
  function update() {
    for (const field of form.elements) if (field.name) chosen[field.name] = field.value;
    const drawn = matrixTable(chosen);
    frame.replaceChildren(drawn.table);
    note.textContent = `${drawn.cells} cells. A click or Enter opens one; arrow keys move. Empty cells say there why.`;
  }
  update();
  const legend = el("p", {}, Object.keys(VERDICTS).map((verdict) => [badge(verdict), " "]));
  return ["Matrix", heading(1, "Schemes and problems"), form, legend, note, frame];
}

function matrixTable(chosen) {
  const part = (name) => !chosen.text || name.includes(chosen.text);
  const fits = (one) => (!chosen.measure || one.measure === chosen.measure) && (!chosen.verdict || one.verdict === chosen.verdict);
  const ofForm = (name) => !chosen.form || (PASSPORTS.problems[name] || {}).form === chosen.form;
  const kept = FINDINGS.filter((one) => fits(one) && ofForm(one.problem) && (part(one.scheme) || part(one.problem)));
  const narrow = chosen.measure || chosen.verdict || chosen.text || chosen.form;
  const schemes = narrow ? unique(kept.map((one) => one.scheme)).sort() : SCHEMES, problems = narrow ? unique(kept.map((one) => one.problem)).sort() : PROBLEMS;
  const cells = grouped(kept, place), longest = Math.max(0, ...problems.map((name) => name.length));
  // Names stand aslant: the row is as high, and the last one as wide, as the longest of them.
  const room = { style: `height: ${(0.46 * longest + 1.5).toFixed(1)}rem` }, last = { style: `${room.style}; padding-right: ${(0.29 * longest).toFixed(1)}rem` };
  const head = el("thead", {}, el("tr", {}, el("th", { class: "corner" }), problems.map((name, column) => el("th", { scope: "col", ...(column === problems.length - 1 ? last : room) }, el("a", { href: link("problem", name) }, name)))));
  const body = el("tbody", { onkeydown: moveFocus }, schemes.map((scheme, row) => el("tr", {}, el("th", { scope: "row" }, schemeLink(scheme)),
    problems.map((problem, column) => el("td", {}, matrixCell(scheme, problem, cells.get(JSON.stringify([scheme, problem])) || [], row + column === 0))))));
  return { table: el("table", { class: "matrix", style: `--columns: ${problems.length}` }, el("caption", { class: "soft" }, kept.length ? "" : "Nothing fits these filters."), head, body), cells: cells.size };
}

function matrixCell(scheme, problem, findings, first) {
  const verdict = worst(findings), counts = grouped(findings, (one) => one.verdict);
  const order = Object.keys(VERDICTS).filter((each) => counts.has(each)), told = order.map((each) => `${counts.get(each).length} ${VERDICTS[each][1]}`).join(", ");
  const missing = findings.length ? [] : missingOf(scheme, problem), why = missing.length ? missing[0].reason : "nothing here fits the filters";
  const text = findings.length ? VERDICTS[verdict][0] + counts.get(verdict).length : "·";
  return el("a", { class: `cell ${verdict}`, href: link("cell", scheme, problem), tabindex: first ? "0" : "-1", title: `${scheme} on ${problem}: ${told || why}`, "aria-label": `${scheme} on ${problem}: ${told || why}` }, text);
}

function moveFocus(event) {
  const step = { ArrowRight: [0, 1], ArrowLeft: [0, -1], ArrowDown: [1, 0], ArrowUp: [-1, 0] }[event.key], cell = event.target.closest("td");
  if (!step || !cell) return;
  const rows = cell.closest("tbody").rows, next = rows[cell.parentNode.rowIndex - 1 + step[0]]?.cells[cell.cellIndex + step[1]]?.querySelector(".cell");
  if (!next) return;
  event.preventDefault();
  event.target.tabIndex = -1;
  next.tabIndex = 0;
  next.focus();
}

function cellPage(_, scheme, problem) {
  const key = JSON.stringify([scheme, problem]), findings = CELLS.get(key) || [], missing = missingOf(scheme, problem);
  const costs = COSTS.filter((one) => one.scheme === scheme && one.problem === problem).map((one) => `${one.kind} ${short(one.mean)}`);
  const first = findings[0] || {};
  const measured = findings.length ? facts([["view", first.view], ["paths", String(first.paths ?? "")], ["seconds", short(first.seconds)], ["per step, finest level", costs.join(", ")]]) : el("p", {}, "No measure applies here.");
  const sections = [...grouped(findings, (one) => one.measure)].map(([measure, list]) => [heading(2, measure), el("div", { class: "cards" }, list.map(card), measure === "invariant" ? densities(scheme, problem) : []), command(list[0])]);
  const absent = missing.length ? [heading(2, "Cells that do not apply, with the reason"), table(["measure", "why"], missing.map((one) => [[one.measures.join(", "), one.quantity].filter(Boolean).join(" "), one.reason]))] : [];
  return [`${scheme} on ${problem}`, el("h1", {}, schemeLink(scheme), " on ", problemLink(problem)), measured, ...sections.flat(), ...absent];
}

const densities = (scheme, problem) => DENSITIES.filter((one) => one.scheme === scheme && one.problem === problem).map((one) => el("article", { class: "card" }, el("h3", {}, one.quantity), density(one)));

function command(finding) {
  return finding.reproduce ? el("div", {}, el("span", { class: "soft" }, "command that reproduces these numbers to the last bit:"), el("pre", {}, finding.reproduce)) : null;
}

/** Return all that is known of a quantity: claim, margin, what decides and guards, orders, reason, picture. */
function card(finding) {
  const along = finding.path_order === null ? "" : interval(finding.path_order, finding.path_low, finding.path_high);
  return el("article", { class: "card" }, el("h3", {}, finding.quantity || finding.measure, " ", badge(finding.verdict)),
    facts([["claim", claimParts(finding)], ["from", finding.claim_source], ["decided by", finding.decided_by], ...LABELS_OF_COLUMNS.map(([name, label]) => [label, typeof finding[name] === "number" ? short(finding[name]) : finding[name]]), ["method", finding.method], ["resolution", resolution(finding)],
      ["local order", finding.local_order === null ? "" : order(finding.local_order)], ["order along paths", along],
      ...["L_half", "L2", "L4"].map((norm) => [`the same in ${norm.replace("_half", "1/2")}`, finite(finding[`order_${norm}`]) ? order(finding[`order_${norm}`]) : ""]),
      [finding.value_of, finding.value === null ? "" : finding.value_of.includes("order") ? interval(finding.value, finding.value_low, finding.value_high) : short(finding.value)],
      ["stable for", finding.windows], ["kind", finding.class], ["tails", finding.heavy_tails === "True" ? "heavy" : ""], ["why", finding.reason], ["classes", finding.conditions]]),
    cardPicture(finding));
}

function cardPicture(finding) {
  const all = points(finding);
  if (!all.length) return null;
  const label = `${finding.measure} ${finding.quantity} of ${finding.scheme} on ${finding.problem}`;
  const head = ["h", "value", "standard error", "fitted"], rows = all.map((point) => [point.h, point.e, point.s, point.filled ? "yes" : `no: ${point.why}`]);
  if (finding.measure === "stability") return figure(radius([finding], label), ["Spectral radius of the second-moment map; below 1 the step size is stable."], head.slice(0, 2), rows.map((row) => row.slice(0, 2)));
  if (all.some((point) => point.eps !== null) && finding.measure === "effort") return heat(all, { label, caption: "Mean number of iterations per step." });
  if (all.some((point) => point.eps !== null) && unique(all.map((point) => point.h)).length === 1) {
    const over = all.map((point) => ({ ...point, h: point.eps }));
    return figure(convergence(over, { label, quantiles: DATA.reach, slopes: slopes(finding), xLabel: "eps" }), ["Distance from the limit against eps."], ["eps", ...head.slice(1)], over.map((point) => [point.h, point.e, point.s, "yes"]));
  }
  if (all.some((point) => point.functional)) return functionals(finding, all, label);
  const fit = finding.path_order, yLabel = axisOf(finding.measure).label;
  const hollow = all.some((point) => !point.filled), seen = finding.levels.fitted ? "fitted" : "above three standard errors";
  const caption = [hollow ? `● ${seen}, ○ not` : finding.levels.fitted ? "● fitted" : "● measured", finite(fit) ? `; line: order along paths ${order(fit)}` : "", finite(finding.claimed_order) ? "; triangles: claim, and claim − margin (dashed)" : "", all.some((point) => point.s) ? `; band: ${short(100 * (settings.confidence || 0.99), 4)} % intervals` : ""];
  return figure(convergence(all, { label, quantiles: DATA.reach, slopes: slopes(finding), fit, yLabel }), caption, head, rows);
}

const slopes = (finding) => [["claimed_order", "claim", "claim"], ["least", "least", "least"]].filter(([name]) => finite(finding[name]))
  .map(([name, kind, label]) => ({ order: finding[name], kind, label }));

function functionals(finding, all, label) {
  const series = [...grouped(all, (point) => point.functional)].map(([name, list]) => ({ name, points: list }));
  return comparison(series, { label, caption: "Supremum over eps of the error, for each functional.", yLabel: "supremum" });
}

/** Draw spectral radii against h, with the line below which a step size is stable. */
function radius(findings, label) {
  const all = points(findings[0]).filter((point) => finite(point.e));
  if (!all.length) return el("p", { class: "soft" }, "Nothing to draw: no spectral radius is known.");
  const x = scaleOf(all.map((point) => point.h), LEFT, WIDTH - RIGHT), y = scaleOf([...all.map((point) => point.e), 1], HEIGHT - BOTTOM, TOP, { log: false });
  const sorted = [...all].sort((a, b) => a.h - b.h);
  return picture(label, HEIGHT, [axes(x, y, { x: "step size h", y: "spectral radius" }), el("line", { class: "least", x1: LEFT, x2: WIDTH - RIGHT, y1: y.at(1), y2: y.at(1) }),
    el("path", { class: "line", d: path(sorted.map((point) => [x.at(point.h), y.at(point.e)])) }), all.map((point) => mark(x, y, { ...point, filled: point.e < 1, why: "not stable" }))]);
}
