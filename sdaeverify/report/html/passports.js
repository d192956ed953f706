// Passports of schemes and problems, and what is compared across them.

const docs = (passport) => (passport && passport.text ? el("pre", {}, passport.text) : el("p", { class: "soft" }, "This page has no description of it."));
const listed = (names) => (names && names.length ? names.join(", ") : "none");

function indexPage(title, names, open, kind) {
  const always = ["verified", "refuted", "inconclusive", "out_of_scope"], found = unique(FINDINGS.map((one) => one.verdict));
  const shown = [...always, ...Object.keys(VERDICTS).filter((verdict) => found.includes(verdict) && !always.includes(verdict))];
  const count = (name, verdict) => FINDINGS.filter((one) => one[kind] === name && one.verdict === verdict).length;
  const rows = names.map((name) => {
    const told = PASSPORTS[`${kind}s`][name] || {};
    return [open(name), told.form || "", (told.text || "").split("\n")[0], ...shown.map((verdict) => count(name, verdict))];
  });
  return [title, heading(1, title), table(["name", "form", "", ...shown.map((verdict) => VERDICTS[verdict][1])], rows)];
}

function schemePage(_, name) {
  const passport = PASSPORTS.schemes[name] || {}, own = FINDINGS.filter((one) => one.scheme === name);
  return [name, heading(1, name), docs(passport), facts([["form", passport.form], ["parameters", Object.entries(passport.parameters || {}).map(([key, told]) => `${key} = ${told}`).join(", ")], ["source", passport.source]]),
    heading(2, "Claims"), claims(passport, own), ...classesOf(name), ...equationsOf(name), heading(2, "Orders on all problems"),
    ...unique(own.map((one) => one.measure)).map((measure) => orders(own.filter((one) => one.measure === measure), name, measure)).flat(),
    ...driftOf(own), ...stabilityOf(own, (one) => one.problem), heading(2, "Cost"), cost(own, name), ...others(own, name)];
}

function claims(passport, own) {
  const of = (claim) => own.filter((one) => one.measure === claim.measure && one.claim === claim.claim && (!claim.quantities.length || claim.quantities.includes(one.quantity)));
  const told = (findings) => Object.keys(VERDICTS).map((verdict) => [verdict, findings.filter((one) => one.verdict === verdict).length]).filter(([, count]) => count).map(([verdict, count]) => [badge(verdict), ` ${count} `]);
  const rows = (passport.claims || []).map((claim) => [claim.measure, claim.claim, claim.margin, claim.quantities.length ? listed(claim.quantities) : "all", claim.when.length ? listed(claim.when) : "all", el("span", {}, told(of(claim))), claim.source]);
  return rows.length ? table(["measure", "claim", "margin", "quantities", "for problems with", "found", "source"], rows) : el("p", { class: "soft" }, "The scheme has no claims, or this page does not have its description.");
}

/** Return a forest plot of what one measure found of a scheme, or of a problem. */
function orders(findings, title, measure, name = (one) => one.problem) {
  const rows = findings.map((one) => {
    return { name: `${name(one)} · ${one.quantity}`, value: one.order_value, low: one.order_low, high: one.order_high, claim: one.claimed_order, least: one.least, filled: one.sampled, told: `${name(one)}, ${one.quantity}: ${found(one)}; ${VERDICTS[one.verdict][1]}; claim ${claimText(one)}` };
  }).filter((row) => finite(row.value));
  return rows.length ? [heading(3, measure), forest(rows, { label: `${measure} orders of ${title}`, caption: ["● order along paths with its interval, ○ without sampling; ticks: the claim, and claim − margin (dashed)."] })] : [];
}

function driftOf(own) {
  const found = own.filter((one) => one.measure === "drift");
  const rows = found.map((one) => [cellLink(one, `${one.scheme} on ${one.problem}`), one.quantity, one.class, finite(one.growth) ? `t^${short(one.growth, 2)}` : "", badge(one.verdict), one.reason]);
  return found.length ? [heading(2, "Constraint drift"), table(["", "residual", "in h", "grows like", "", "why"], rows)] : [];
}

function stabilityOf(own, name) {
  const rows = own.filter((one) => one.windows).map((one) => ({ name: name(one), text: one.windows, windows: stableSets(one.windows) }));
  return rows.length ? [heading(2, "Stability"), windows(rows, { label: "stable step sizes", caption: "Step sizes for which second moments tend to 0." })] : [];
}

function cost(own, name) {
  const times = [...grouped(own, (one) => one.problem)].map(([problem, group]) => [problemLink(problem), Math.max(...group.map((one) => one.seconds || 0)), group[0].paths, COSTS.filter((one) => one.scheme === name && one.problem === problem).map((one) => `${one.kind} ${short(one.mean)}`).join(", ")]);
  return table(["problem", "seconds, all measures", "paths", "per step at the finest level"], times);
}

function others(own, name) {
  const problems = unique(own.filter((one) => one.measure === "strong" && one.levels.h).map((one) => one.problem));
  return problems.length ? [heading(2, "Compared with the other schemes on the same noise"), picker(problems, "problem", (problem) => sameNoise(problem, name))] : [];
}

/** Return a choice and what it shows. */
function picker(names, label, show) {
  const frame = el("div"), choose = el("select", { onchange: () => frame.replaceChildren(...[show(choose.value)].flat(Infinity).filter(Boolean)) }, names.map((name) => el("option", { value: name }, name)));
  frame.append(...[show(names[0])].flat(Infinity).filter(Boolean));
  return el("div", {}, names.length > 1 ? el("form", { class: "filters", onsubmit: (event) => event.preventDefault() }, el("label", {}, label, choose)) : null, frame);
}

/** Draw the errors of all schemes on a problem against the step size: the noise is the same for all. */
function sameNoise(problem, first = "", measure = "strong") {
  const here = FINDINGS.filter((one) => one.problem === problem && one.measure === measure && (one.levels.h || []).length);
  const quantities = unique(here.map((one) => one.quantity));
  if (!quantities.length) return [el("p", { class: "soft" }, "Nothing to compare.")];
  return [picker(quantities, "quantity", (quantity) => {
    const series = here.filter((one) => one.quantity === quantity).map((one) => ({ name: one.scheme, points: points(one) }));
    series.sort((a, b) => (b.name === first) - (a.name === first));
    const { told, label: yLabel, rule, log } = axisOf(measure);
    return [comparison(series, { label: `${measure} ${quantity} of all schemes on ${problem}`, caption: `${told} of ${quantity} on ${problem}${measure === "strong" ? ", on the same noise" : ""}.`, yLabel, rule, log }),
      ...(["strong", "weak"].includes(measure) ? [work(here.filter((one) => one.quantity === quantity), `${measure} ${quantity}`, problem, first)] : [])].flat();
  })];
}

/** Draw errors against the time that a path takes: the further left and below, the better. */
function work(findings, told, problem, first) {
  const timed = findings.filter((one) => finite(one.step_seconds) && one.levels.steps);
  const series = timed.map((one) => ({ name: one.scheme, points: points(one).map((point, place) => ({ ...point, h: value(one.levels.steps[place]) * one.step_seconds })) }));
  series.sort((a, b) => (b.name === first) - (a.name === first));
  return series.length ? comparison(series, { label: `work and precision, ${told} on ${problem}`, xLabel: "seconds a path", yLabel: axisOf(findings[0].measure).label,
    caption: `Work against precision: errors on ${problem} against the measured time of a path's steps. Further left and below is better.` }) : null;
}

function problemPage(_, name) {
  const passport = PASSPORTS.problems[name] || {}, own = FINDINGS.filter((one) => one.problem === name);
  const measured = ["strong", "weak", "invariant", "drift"].filter((measure) => own.some((one) => one.measure === measure && (one.levels.h || []).length));
  return [name, heading(1, name), docs(passport), facts([["form", passport.form], ["parameters", Object.entries(passport.parameters || {}).map(([key, told]) => `${key} = ${told}`).join(", ")], ["Brownian motions", passport.noise && String(passport.noise)], ["horizon", passport.horizon && `${short(passport.horizon)} (${passport.units})`],
    ["traits", passport.traits && listed(passport.traits)], ["observables", passport.observables && listed(passport.observables)], ["source", passport.source]]),
    ...choicesOn(name), heading(2, "Truths"), passport.truths && passport.truths.length ? el("ul", {}, passport.truths.map((truth) => el("li", {}, truth))) : el("p", { class: "soft" }, "None: no order is verified by paths alone."),
    heading(2, "Controls: does the problem distinguish orders?"), controls(passport, own),
    ...measured.map((measure) => [heading(2, `${measure}, all schemes`), ...sameNoise(name, "", measure)]).flat(),
    ...unique(own.map((one) => one.measure)).map((measure) => orders(own.filter((one) => one.measure === measure), name, measure, (one) => one.scheme)).flat(), ...stabilityOf(own, (one) => one.scheme)];
}

/** Return the work that each scheme needs for an accuracy, the least first, for each measure of errors. */
function choicesOn(problem) {
  const here = (DATA.choices || []).filter((one) => one.problem === problem);
  const rows = (one) => one.schemes.map((each) => [badge(each.verdict), schemeLink(each.scheme), each.claim || "none", order(each.order), each.noise, short(each.error, 2),
    finite(each.steps) ? `${each.beyond ? "~" : ""}${each.steps}` : "", finite(each.seconds) ? `${short(1e6 * each.seconds, 3)} µs` : "?"]);
  return here.length ? [heading(2, "Which scheme for this problem?"),
    el("p", { class: "soft" }, "Work for the accuracy that half of the schemes reach, the least first: the measured time of the steps of a path. Errors of verified schemes count, the limit of others need not be the solution; schemes with a refuted claim are left out. ~ more steps than were made, by the order; ? errors are within their noise, or take too many steps."),
    ...here.map((one) => [heading(3, `${one.measure} ${one.quantity}: error ${short(one.accuracy)}`), table(["", "scheme", "claim", "order", "noise", "error at the finest h", "steps", "work"], rows(one), { class: "blocks" })]).flat()] : [];
}

function controls(passport, own) {
  const told = (one) => [finite(one.local_order) ? `${order(one.local_order)} in one step` : "", finite(one.path_order) ? `${order(one.path_order)} along paths` : ""].filter(Boolean).join(", ");
  const outcome = (scheme, control) => {
    const findings = own.filter((one) => one.scheme === scheme && one.measure === control.measure);
    return el("span", {}, el("a", { href: link("cell", scheme, passport.label) }, scheme), " ", findings.length ? told(findings[0]) : el("span", { class: "soft" }, "not in this run"));
  };
  const rows = (passport.controls || []).map((control) => [control.measure, control.order, outcome(control.positive, control), outcome(control.negative, control)]);
  return rows.length ? table(["measure", "order", "has it", "has it not"], rows) : el("p", { class: "soft" }, "None is declared.");
}

/** Return a page that compares all schemes in one measure, a problem at a time. */
function measurePage(title, measure, intro) {
  return () => {
    const here = FINDINGS.filter((one) => one.measure === measure), problems = unique(here.map((one) => one.problem)).sort();
    const passport = PASSPORTS.measures[measure];
    return [title, heading(1, title), el("p", {}, intro), picker(problems, "problem", (problem) => {
      const own = here.filter((one) => one.problem === problem);
      const bars = measure === "stability" ? stabilityOf(own, (one) => one.scheme) : [];
      const growth = own.find((one) => finite(one.growth_rate));
      return [...bars, growth ? el("p", { class: "soft" }, `Growth rate of the second moment of the equation: ${short(growth.growth_rate, 4)}.`) : null, ...sameNoise(problem, "", measure), ...orders(own, problem, measure, (one) => one.scheme), ...(measure === "drift" ? driftOf(own).slice(1) : []), ...(measure === "invariant" ? densityChoice(problem) : [])];
    }), passport ? el("details", {}, el("summary", {}, "how it is measured"), docs(passport)) : null];
  };
}

/** Return the densities on a problem, a scheme at a time. */
function densityChoice(problem) {
  const here = DENSITIES.filter((one) => one.problem === problem);
  return here.length ? [heading(2, "Stationary densities on the chart"), picker(unique(here.map((one) => one.scheme)), "scheme", (scheme) => el("div", { class: "cards" }, densities(scheme, problem)))] : [];
}

function uniformityPage() {
  const here = FINDINGS.filter((one) => ["uniformity", "limits", "effort"].includes(one.measure));
  return ["Uniformity", heading(1, "Uniformity in the stiffness eps"), el("p", {}, "Suprema of errors over eps, distances from the limit eps = 0, and iterations over eps and h."),
    ...[...grouped(here, place).values()].map((group) => [el("h2", {}, cellLink(group[0], `${group[0].scheme} on ${group[0].problem}`)), el("div", { class: "cards" }, group.map(card))]).flat()];
}

function verifierPage() {
  const { kills, calibration } = DATA.verifier;
  return ["Verifier", heading(1, "Is the verifier right?"),
    kills.length > 1 ? [heading(2, "Planted bugs, and which check refutes them"), table(kills[0], kills.slice(1))] : [],
    calibration.length > 1 ? [heading(2, "How often intervals contain the truth, and how often tests are wrong"), coverage(calibration)] : []].flat();
}

function coverage([head, ...rows]) {
  const records = rows.map((row) => Object.fromEntries(head.map((name, place) => [name, row[place]])));
  // Rates near 0 and near 1 have an axis each, or neither would be seen.
  const parts = (found) => [found.filter((one) => +one.rate < 0.5), found.filter((one) => !(+one.rate < 0.5))];
  return [...grouped(records, (one) => `${one.study}: ${one.case}`)].map(([study, found]) => [heading(3, study),
    ...parts(found).map((part) => forest(part.map((one) => ({ name: `${one.statistic}${one.paths ? ` · ${+one.paths} paths` : ""}`, value: +one.rate, low: +one.ci_low, high: +one.ci_high, filled: one.agrees === "True", told: `${one.case}, ${one.statistic}: ${short(+one.rate)}; promised ${one.promised}` })), { label: `rates of ${study}`, xLabel: "rate", caption: ["● as promised, ○ not; with binomial intervals."] }))]).flat(2).filter(Boolean);
}
