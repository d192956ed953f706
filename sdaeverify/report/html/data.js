// The numbers of the run as records, and how they are found.

const DATA = JSON.parse(document.getElementById("data").textContent);
const { verdicts: VERDICTS, attention: ATTENTION, axes: AXES, clear: CLEAR } = DATA.pictures;
const axisOf = (measure) => AXES[measure] || AXES[""];
const LABELS_OF_COLUMNS = DATA.labels || [];
const value = (given) => (given === "inf" ? Infinity : given === "-inf" ? -Infinity : given);
const word = (given, place) => (Array.isArray(place) ? place.map((each) => given.words[each]) : given.words[place]);
const column = (given) => (Array.isArray(given) ? given.map(value) : given.at.map((place) => word(given, place)));

/** Return columns as records. */
function records(columns) {
  const read = Object.entries(columns).map(([name, given]) => [name, column(given)]);
  return (read.length ? read[0][1] : []).map((_, place) => Object.fromEntries(read.map(([name, cells]) => [name, cells[place]])));
}

const FINDINGS = records(DATA.findings).map((one, place) => ({ ...one, levels: DATA.levels[place] || {}, place }));
const ABSENT = records(DATA.absent).map((one) => ({ ...one, problems: new Set(one.problems) })), COSTS = DATA.costs || [], DENSITIES = DATA.densities || [];
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
const CELLS = grouped(FINDINGS, place), MISSING = grouped(ABSENT, (one) => one.scheme);
const SCHEMES = unique([...FINDINGS, ...ABSENT].map((one) => one.scheme)).sort();
const PROBLEMS = unique([...FINDINGS.map((one) => one.problem), ...ABSENT.flatMap((one) => [...one.problems])]).sort();

/** Return why measures do not apply to a cell: groups of measures with one reason each. */
const missingOf = (scheme, problem) => (MISSING.get(scheme) || []).filter((one) => one.problems.has(problem));
const MEASURES = unique(FINDINGS.map((one) => one.measure)).sort();
const settings = DATA.run.settings || {};

/** Return the levels of a finding as points; where it is not recorded which are fitted, those that differ from 0. */
function points(finding) {
  const levels = finding.levels, count = (levels.h || []).length;
  return Array.from({ length: count }, (_, n) => {
    const of = (name) => (levels[name] ? value(levels[name][n]) : null), error = of("estimate"), spread = of("std_error") || 0;
    const seen = levels.fitted ? of("fitted") === 1 : !spread || Math.abs(error) > CLEAR * spread;
    return { h: of("h"), e: error, s: spread, eps: of("eps") ?? of("worst_eps"), functional: of("functional") || "", filled: seen, why: seen ? "" : reasonHollow(levels, of) };
  });
}

function reasonHollow(levels, of) {
  if (of("failed_paths") || of("failed")) return "paths failed";
  if (of("truncated_share")) return "steps were truncated";
  return levels.fitted ? "coarser than the fitted levels, or close to rounding errors" : "less than three standard errors from 0";
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
  if (finding.resolution === Infinity) return "none: no error of the limit would be detected";
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
