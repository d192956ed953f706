// Which page is shown, and the way between them.

const has = (...measures) => FINDINGS.some((one) => measures.includes(one.measure));
const ROUTES = { summary: summaryPage, matrix: matrixPage, cell: cellPage, scheme: schemePage, problem: problemPage,
  schemes: () => indexPage("Schemes", SCHEMES, schemeLink, "scheme"), problems: () => indexPage("Problems", PROBLEMS, problemLink, "problem"),
  drift: measurePage("Constraint drift", "drift", "How far constraints are violated along paths, against the step size, and how that grows in time."),
  stability: measurePage("Stability", "stability", "Mean-square stability: sets of stable step sizes, and the spectral radius of the second-moment map against h."),
  invariant: measurePage("Invariant law", "invariant", "Errors of stationary means against the step size."), uniformity: uniformityPage, verifier: verifierPage, history: historyPage, table: tablePage };
const NAVIGATION = [["summary", "Summary", FINDINGS.length], ["matrix", "Matrix", FINDINGS.length], ["schemes", "Schemes", FINDINGS.length], ["problems", "Problems", FINDINGS.length], ["drift", "Drift", has("drift")],
  ["stability", "Stability", has("stability")], ["invariant", "Invariant", has("invariant")], ["uniformity", "Uniformity", has("uniformity", "limits", "effort")], ["verifier", "Verifier", DATA.verifier], ["history", "History", DATA.history],
  ...(DATA.tables || []).map((each, number) => [`table/${number}`, each.title, true])];
const HOME = (NAVIGATION.find(([, , there]) => there) || ["summary"])[0];

/** Return a page of a table that was written as one. */
function tablePage(_, number) {
  const { title, text, head, rows } = DATA.tables[Number(number)];
  return [title, heading(1, title), el("p", {}, DATA.sentence), (text || []).map((line) => el("p", {}, line)), table(head, rows)].flat();
}

function show() {
  const [route, search = ""] = location.hash.replace(/^#\/?/, "").split("?");
  const [page, ...names] = (route || HOME).split("/").map(decodeURIComponent);
  const query = Object.fromEntries(new URLSearchParams(search));
  const [title, ...content] = (ROUTES[page] && (DATA[page] || !["verifier", "history"].includes(page)) ? ROUTES[page] : ROUTES[HOME.split("/")[0]])(query, ...names);
  document.title = `${title} · sdaeverify`;
  document.getElementById("main").replaceChildren(...content.flat(Infinity).filter(Boolean));
  for (const anchor of document.querySelectorAll("nav a")) {
    if (anchor.hash === `#/${(route || HOME)}`) anchor.setAttribute("aria-current", "page");
    else anchor.removeAttribute("aria-current");
  }
}

document.querySelector("nav").append(...NAVIGATION.filter(([, , there]) => there).map(([page, title]) => el("a", { href: link(...page.split("/")) }, title)));
addEventListener("hashchange", (event) => {
  if (location.hash === "#main") return;
  show();
  document.getElementById("main").focus({ preventScroll: true });
  scrollTo(0, 0);
});
show();
