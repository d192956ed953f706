// Which page is shown, and the way between them.

// The overview of a large run has no details to compare by measure, and the page of a problem is reached from it.
const has = (...measures) => !DATA.parts && !ABOVE && FINDINGS.some((one) => measures.includes(one.measure));
const ROUTES = { summary: summaryPage, matrix: matrixPage, cell: cellPage, scheme: schemePage, problem: problemPage,
  schemes: () => indexPage("Schemes", SCHEMES, schemeLink, "scheme"), problems: () => indexPage("Problems", PROBLEMS, problemLink, "problem"),
  drift: measurePage("Constraint drift", "drift", "How far constraints are violated along paths, against the step size, and how that grows in time."),
  stability: measurePage("Stability", "stability", "Mean-square stability: sets of stable step sizes, and the spectral radius of the second-moment map against h."),
  invariant: measurePage("Invariant law", "invariant", "Errors of stationary means against the step size."), uniformity: uniformityPage, classes: classesPage, verifier: verifierPage, table: tablePage };
const NAVIGATION = [["summary", "Summary", FINDINGS.length], ["matrix", "Matrix", FINDINGS.length], ["schemes", "Schemes", FINDINGS.length], ["problems", "Problems", FINDINGS.length], ["drift", "Drift", has("drift")],
  ["stability", "Stability", has("stability")], ["invariant", "Invariant", has("invariant")], ["uniformity", "Uniformity", has("uniformity", "limits", "effort")], ["classes", "Classes", CLASS_ROWS.length && !FINDINGS.length], ["verifier", "Verifier", DATA.verifier],
  ...(DATA.tables || []).map((each, number) => [`table/${number}`, each.title, true])];
// Pages of things, and what their names may be.
const OF_THINGS = { cell: [SCHEMES, PROBLEMS], scheme: [SCHEMES], problem: [PROBLEMS], table: [(DATA.tables || []).map((_, number) => String(number))] };
const HOME = ABOVE ? ["problem", PROBLEMS[0]] : (NAVIGATION.find(([, , there]) => there) || ["summary"])[0].split("/");

/** Return a page of a table that was written as one. */
function tablePage(_, number) {
  const { title, text, picture, head, rows } = DATA.tables[Number(number)];
  return [title, heading(1, title), el("p", {}, DATA.sentence), (text || []).map((line) => el("p", {}, line)), picture ? el("img", { src: picture, alt: `${title}: figure`, class: "figure" }) : [], el("div", { class: "wide" }, table(head, rows))].flat();
}

/** Return the words of an address that leads to a page of this run, and those of the first page for any other. */
function placeOf(route) {
  let words = [];
  try {
    words = route.split("/").map(decodeURIComponent);
  } catch {
    // No text that a browser or this page has made.
  }
  const [page, ...names] = words;
  const there = Object.hasOwn(OF_THINGS, page) ? names.length === OF_THINGS[page].length && OF_THINGS[page].every((known, place) => known.includes(names[place])) :
    !ABOVE && !names.length && NAVIGATION.some(([name, , shown]) => name === page && shown);
  return there ? words : HOME;
}

function show() {
  const [asked, search = ""] = location.hash.replace(/^#\/?/, "").split("?");
  const [page, ...names] = placeOf(asked);
  const query = Object.fromEntries(new URLSearchParams(search));
  const [title, ...content] = ROUTES[page](query, ...names);
  document.title = `${title} · sdaeverify`;
  document.getElementById("main").replaceChildren(...content.flat(Infinity).filter(Boolean));
  for (const anchor of document.querySelectorAll("nav a")) {
    if (anchor.hash === link(page, ...names)) anchor.setAttribute("aria-current", "page");
    else anchor.removeAttribute("aria-current");
  }
}

if (ABOVE) document.querySelector("nav").append(el("a", { href: link(...HOME) }, HOME[1]));
document.querySelector("nav").append(...NAVIGATION.filter(([, , there]) => there).map(([page, title]) => el("a", { href: link(...page.split("/")) }, title)));
addEventListener("hashchange", (event) => {
  if (location.hash === "#main") return;
  show();
  document.getElementById("main").focus({ preventScroll: true });
  scrollTo(0, 0);
});
show();
