// The numbers of the run as records, and how they are found.

const DATA = JSON.parse(document.getElementById("data").textContent);
const { verdicts: VERDICTS, attention: ATTENTION, axes: AXES, clear: CLEAR } = DATA.pictures;
const axisOf = (measure) => AXES[measure] || AXES[""];
const TEXTS = DATA.text_columns || [], LABELS_OF_COLUMNS = DATA.labels || [];
const value = (given) => (given === "inf" ? Infinity : given === "-inf" ? -Infinity : given);

/** Return the findings as records, each with the columns of its levels. */
function records() {
  const columns = DATA.findings, count = (columns.scheme || []).length;
  return Array.from({ length: count }, (_, place) => {
    const record = { levels: DATA.levels[place], place };
    for (const [name, column] of Object.entries(columns)) record[name] = TEXTS.includes(name) ? DATA.texts[column[place]] : value(column[place]);
    return record;
  });
}

const FINDINGS = records();
const ABSENT = Array.from({ length: (DATA.absent || []).length / 4 }, (_, place) => {
  const [scheme, problem, measure, reason] = DATA.absent.slice(4 * place, 4 * place + 4).map((number) => DATA.texts[number]);
  return { scheme, problem, measure, reason };
});
const COSTS = (DATA.costs || []).map(([scheme, problem, kind, mean]) => ({ scheme: DATA.texts[scheme], problem: DATA.texts[problem], kind: DATA.texts[kind], mean }));
const DENSITIES = (DATA.densities || []).map(([scheme, problem, quantity, h, at, own, exact]) => ({ scheme: DATA.texts[scheme], problem: DATA.texts[problem], quantity: DATA.texts[quantity], h, at, own, exact }));
const PASSPORTS = { schemes: {}, problems: {}, measures: {}, ...DATA.passports };

function grouped(list, key) {
  const groups = new Map();
  for (const one of list) {
    const name = key(one);
    if (!groups.has(name)) groups.set(name, []);
    groups.get(name).push(one);
  }
  return groups;
}

const unique = (list) => [...new Set(list)];
const place = (one) => JSON.stringify([one.scheme, one.problem]);
const CELLS = grouped(FINDINGS, place), MISSING = grouped(ABSENT, place);
const SCHEMES = unique([...FINDINGS, ...ABSENT].map((one) => one.scheme)).sort();
const PROBLEMS = unique([...FINDINGS, ...ABSENT].map((one) => one.problem)).sort();
const MEASURES = unique(FINDINGS.map((one) => one.measure)).sort();
const settings = DATA.run.settings || {};

/** Return the levels of a finding as points; where it is not recorded which are fitted, those that differ from 0. */
function points(finding) {
  const levels = finding.levels, count = (levels.h || []).length;
  return Array.from({ length: count }, (_, n) => {
    const of = (name) => (levels[name] ? value(levels[name][n]) : null), error = of("e"), spread = of("s") || 0;
    const seen = levels.f ? of("f") === 1 : !spread || Math.abs(error) > CLEAR * spread;
    return { h: of("h"), e: error, s: spread, eps: of("eps"), functional: levels.u ? DATA.texts[levels.u[n]] : "", filled: seen, why: seen ? "" : reasonHollow(levels, of) };
  });
}

function reasonHollow(levels, of) {
  if (of("x")) return "paths failed";
  if (of("t")) return "steps were truncated";
  return levels.f ? "coarser than the levels that are fitted, or next to rounding" : "less than three standard errors from 0";
}

const worst = (findings) => Object.keys(VERDICTS).find((verdict) => findings.some((one) => one.verdict === verdict)) || "not_applicable";

/** Return an order with its interval in words. */
function interval(mid, low, high) {
  if (mid === null || mid === undefined) return "";
  if (!finite(low) && low !== null && high !== null) return order(mid);
  if (finite(low) && high === Infinity) return `at least ${order(low)}`;
  return finite(low) && finite(high) ? `${order(mid)} [${order(low)}, ${order(high)}]` : order(mid);
}

/** Return in a few words what was found: the order along paths, else the local one, else what the measure estimates. */
function found(finding) {
  if (finite(finding.path_order)) return `${interval(finding.path_order, finding.path_low, finding.path_high)} along paths`;
  if (finite(finding.local_order)) return `${order(finding.local_order)} in one step`;
  if (finding.value === null) return "";
  if (finding.value_of.includes("order")) return interval(finding.value, finding.value_low, finding.value_high);
  const spread = finite(finding.value_low) && finite(finding.value_high) ? ` [${short(finding.value_low)}, ${short(finding.value_high)}]` : "";
  return `${short(finding.value)}${spread} (${finding.value_of})`;
}

/** Return in words which errors of the limit the evidence would have shown; empty where nothing is said of a limit. */
function resolution(finding) {
  if (finding.resolution === Infinity) return "none: no error of the limit would show";
  return finite(finding.resolution) ? `${short(100 * finding.resolution, 2)} %: a larger error of the limit would show` : "";
}

/** Return sets of step sizes that a text such as "h < 0.5; 2 < h < 3" tells of, as pairs. */
function stableSets(text) {
  if (!text || text === "none") return [];
  if (text === "all h") return [[0, Infinity]];
  return text.split(";").map((part) => {
    const numbers = (part.match(/[0-9.]+(?:e[-+]?[0-9]+)?/g) || []).map(Number);
    if (part.includes("h >")) return [numbers[0], Infinity];
    return numbers.length > 1 ? numbers : [0, numbers[0]];
  });
}
