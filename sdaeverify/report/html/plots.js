"use strict";
// Elements and pictures: plain SVG, every mark with its numbers, every picture with a table beside it.

/** Return an element; children that are texts become text nodes, never markup. */
function el(tag, attributes = {}, ...children) {
  const spaces = { svg: 1, g: 1, path: 1, line: 1, circle: 1, rect: 1, text: 1, title: 1, polygon: 1, desc: 1 };
  const made = spaces[tag] ? document.createElementNS("http://www.w3.org/2000/svg", tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value !== null && value !== undefined && value !== false) made.setAttribute(name, value);
  }
  made.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== ""));
  return made;
}

const finite = (value) => typeof value === "number" && Number.isFinite(value);
const WIDTH = 420, HEIGHT = 280, LEFT = 70, RIGHT = 16, TOP = 12, BOTTOM = 40;

/** Return a number in few digits, minus signs as such. */
function short(value, digits = 3) {
  if (value === null || value === undefined) return "";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : "−∞";
  const size = Math.abs(value);
  const text = size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential(1) : String(+value.toPrecision(digits));
  return text.replaceAll("-", "−");
}

/** Return an order: two digits after the point. */
const order = (value) => (finite(value) ? value.toFixed(2).replace("-", "−") : short(value));

/** Return a scale from a domain to pixels, logarithmic or not, with its ticks. */
function scaleOf(values, from, to, { log = true, least = 0 } = {}) {
  const known = values.filter((value) => finite(value) && (!log || value > 0));
  const forward = log ? Math.log10 : (value) => value;
  let low = Math.min(...known.map(forward)), high = Math.max(...known.map(forward));
  if (!known.length) [low, high] = [0, 1];
  const middle = (low + high) / 2, half = Math.max((high - low) / 2, least / 2, log ? 0.15 : 1e-9) * 1.08;
  [low, high] = [middle - half, middle + half];
  const at = (value) => from + ((forward(value) - low) / (high - low)) * (to - from);
  return { at, ticks: log ? logTicks(low, high) : linearTicks(low, high), low, high, log };
}

function logTicks(low, high) {
  const step = Math.max(1, Math.ceil((high - low) / 6)), ticks = [];
  for (let power = Math.ceil(low); power <= high; power += step) ticks.push(10 ** power);
  if (ticks.length > 1) return ticks;
  const fine = [1, 2, 3, 5].flatMap((digit) => [Math.floor(low), Math.floor(low) + 1].map((power) => digit * 10 ** power));
  return fine.filter((tick) => Math.log10(tick) >= low && Math.log10(tick) <= high).sort((a, b) => a - b);
}

function linearTicks(low, high) {
  const rough = (high - low) / 5, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 2.5, 5, 10].map((digit) => digit * power).find((each) => each >= rough), ticks = [];
  for (let tick = Math.ceil(low / step) * step; tick <= high + 1e-12; tick += step) ticks.push(+tick.toPrecision(12));
  return ticks;
}

/** Return a tick in words: powers of ten as such. */
function tickText(tick, log) {
  const power = Math.floor(Math.log10(tick) + 1e-9), digit = Math.round(tick / 10 ** power);
  if (!log || (power >= -3 && power < 4)) return short(tick, 4);
  return (digit === 1 ? "" : `${digit}·`) + "10" + String(power).replace("-", "⁻").replace(/\d/g, (each) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[each]);
}

/** Return axes with ticks and labels. */
function axes(x, y, labels, height = HEIGHT, width = WIDTH) {
  const bottom = height - BOTTOM, right = width - RIGHT, g = el("g", { "aria-hidden": "true" });
  for (const tick of y.ticks)
    g.append(el("line", { class: "grid", x1: LEFT, x2: right, y1: y.at(tick), y2: y.at(tick) }),
      el("text", { class: "soft", x: LEFT - 6, y: y.at(tick) + 4, "text-anchor": "end" }, tickText(tick, y.log)));
  for (const tick of x.ticks)
    g.append(el("line", { class: "grid", y1: TOP, y2: bottom, x1: x.at(tick), x2: x.at(tick) }),
      el("text", { class: "soft", x: x.at(tick), y: bottom + 15, "text-anchor": "middle" }, tickText(tick, x.log)));
  g.append(el("path", { class: "axis", d: `M${LEFT},${TOP}V${bottom}H${right}` }),
    el("text", { x: (LEFT + right) / 2, y: height - 6, "text-anchor": "middle" }, labels.x),
    el("text", { x: 0, y: 0, transform: `translate(12,${(TOP + bottom) / 2}) rotate(-90)`, "text-anchor": "middle" }, labels.y));
  return g;
}

/** Return a picture in its frame. */
function picture(label, height, children, width = WIDTH) {
  return el("svg", { viewBox: `0 0 ${width} ${height}`, width, height, role: "img", "aria-label": label }, ...children);
}

/** Return a figure: a picture, what is to be seen, and its numbers as a table. */
function figure(drawn, caption, head, rows) {
  return el("figure", {}, el("div", { class: "wide" }, drawn), el("figcaption", {}, ...[caption].flat()),
    head && el("details", {}, el("summary", {}, "numbers"), table(head, rows)));
}

/** Return a table; numbers are aligned to the right. */
function table(head, rows, attributes = {}) {
  const numeric = head.map((_, place) => rows.length > 0 && rows.every((row) => typeof row[place] === "number" || row[place] === null));
  const kind = (place) => (numeric[place] ? "n" : null);
  const cell = (value) => (typeof value === "number" ? short(value, 5) : value);
  return el("div", { class: "wide" }, el("table", attributes,
    el("thead", {}, el("tr", {}, head.map((name, place) => el("th", { scope: "col", class: kind(place) }, name)))),
    el("tbody", {}, rows.map((row) => el("tr", {}, row.map((value, place) => el("td", { class: kind(place), "data-label": head[place] || null }, cell(value))))))));
}

const path = (points) => "M" + points.map(([x, y]) => `${x.toFixed(2)},${y.toFixed(2)}`).join("L");

/** Return a mark: filled where a level is fitted, hollow where not, with its numbers. */
function mark(x, y, point, kind = "dot") {
  const why = point.filled ? "" : `; not fitted${point.why ? `: ${point.why}` : ""}`;
  const text = `h = ${short(point.h, 5)}: ${short(point.e, 5)}${point.s ? ` ± ${short(point.s, 2)} (standard error)` : ""}${why}`;
  return el("circle", { class: `${kind}${point.filled ? "" : " hollow"}`, cx: x.at(point.h).toFixed(3), cy: y.at(Math.abs(point.e)).toFixed(3), r: 4,
    "data-h": point.h, "data-e": point.e }, el("title", {}, text));
}

/**
 * Draw errors against h on logarithmic axes, with the band of their intervals, the fitted slope and triangles.
 *
 * points: [{h, e, s, filled, why}]; slopes: [{order, class, label}] through the middle of the filled points.
 */
function convergence(points, { label, quantiles, slopes, fit, xLabel = "step size h", yLabel = "error" }) {
  const shown = points.filter((point) => finite(point.e) && point.e !== 0 && point.h > 0);
  if (!shown.length) return el("p", { class: "soft" }, "Nothing to draw: no error differs from 0.");
  const reach = (point) => [Math.abs(point.e) - quantiles * (point.s || 0), Math.abs(point.e) + quantiles * (point.s || 0)];
  const floor = Math.min(...shown.map((point) => Math.abs(point.e))) / 10;
  const x = scaleOf(shown.map((point) => point.h), LEFT, WIDTH - RIGHT);
  const y = scaleOf(shown.flatMap((point) => [Math.abs(point.e), Math.max(reach(point)[0], floor), reach(point)[1]]), HEIGHT - BOTTOM, TOP, { least: 0.6 });
  const children = [axes(x, y, { x: xLabel, y: yLabel })];
  // Values without sampling error, which the operator gives on other step sizes, have no interval and no part in the band.
  const sampled = shown.filter((point) => point.s);
  const edge = (place) => sampled.map((point) => [x.at(point.h), Math.min(HEIGHT - BOTTOM, y.at(Math.max(reach(point)[place], floor)))]);
  if (sampled.length > 1)
    children.push(el("path", { class: "band", d: path([...edge(1), ...edge(0).reverse()]) + "Z" }, el("title", {}, "intervals of the errors")));
  const filled = shown.filter((point) => point.filled);
  if (fit && finite(fit) && filled.length > 1) children.push(slopeLine(filled, fit, x, y));
  children.push(...triangles(filled.length > 1 ? filled : shown, slopes, x, y), ...shown.map((point) => mark(x, y, point)));
  return picture(label, HEIGHT, children);
}

const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;

function slopeLine(filled, fit, x, y) {
  const centre = [mean(filled.map((point) => Math.log10(point.h))), mean(filled.map((point) => Math.log10(Math.abs(point.e))))];
  const at = (h) => [x.at(h), y.at(10 ** (centre[1] + fit * (Math.log10(h) - centre[0])))];
  const sizes = filled.map((point) => point.h);
  return el("path", { class: "line", d: path([at(Math.min(...sizes)), at(Math.max(...sizes))]), "data-slope": fit });
}

/** Return a right triangle for each slope, below the points, beside each other. */
function triangles(points, slopes, x, y) {
  const sizes = points.map((point) => Math.log10(point.h));
  const least = Math.log10(Math.min(...points.map((point) => Math.abs(point.e))));
  return slopes.flatMap(({ order: slope, kind, label }, place) => {
    const across = x.high - x.low, wide = Math.min(Math.max(0.15, across * 0.2), across * 0.3, (0.6 * (y.high - y.low)) / Math.max(slope, 0.1));
    const right = Math.max(Math.max(...sizes) - place * across * 0.36, x.low + across * 0.02 + wide), left = right - wide;
    const base = Math.max(y.low + (y.high - y.low) * 0.04, Math.min(least, y.high - slope * wide) - slope * wide * 0.2);
    const corner = ([h, e]) => [x.at(10 ** h), y.at(10 ** e)];
    const corners = [[left, base], [right, base], [right, base + slope * wide]].map(corner);
    return [el("path", { class: kind, d: path(corners) + "Z", "data-slope": slope }, el("title", {}, `slope ${order(slope)}: ${label}`)),
      el("text", { class: kind, x: corners[0][0] + 2, y: corners[2][1] - 4 }, `${label} ${order(slope)}`)];
  });
}

/** Draw several series on the same axes, one of them chosen by the buttons of the legend; others are grey. */
function comparison(series, { label, xLabel = "step size h", yLabel = "error", log = true, logX = true, caption, rule = null }) {
  const known = series.map((one) => ({ ...one, points: one.points.filter((p) => finite(p.h) && p.h > 0 && finite(p.e) && (!log || p.e !== 0)) })).filter((one) => one.points.length);
  if (!known.length) return el("p", { class: "soft" }, "Nothing to draw here.");
  const value = (point) => (log ? Math.abs(point.e) : point.e), all = known.flatMap((one) => one.points);
  const width = 640, height = 340;
  const x = scaleOf(all.map((point) => point.h), LEFT, width - RIGHT, { log: logX });
  if (!logX) x.ticks = x.ticks.filter(Number.isInteger);
  const y = scaleOf([...all.map(value), ...(rule === null ? [] : [rule])], height - BOTTOM, TOP, { log });
  const ordered = (points) => [...points].sort((a, b) => a.h - b.h);
  const groups = known.map((one) => el("g", {}, el("title", {}, one.name),
    el("path", { class: "other", d: path(ordered(one.points).map((point) => [x.at(point.h), y.at(value(point))])) }),
    one.points.map((point) => el("circle", { class: `other dot${point.filled === false ? " hollow" : ""}`, r: 2.5, cx: x.at(point.h).toFixed(3), cy: y.at(value(point)).toFixed(3), "data-h": point.h, "data-e": point.e },
      el("title", {}, `${one.name}: ${short(point.e, 4)} at ${short(point.h, 4)}`)))));
  const line = rule === null ? [] : [el("line", { class: "least", x1: LEFT, x2: width - RIGHT, y1: y.at(rule), y2: y.at(rule) })];
  const drawn = picture(label, height, [axes(x, y, { x: xLabel, y: yLabel }, height, width), ...line, ...groups], width);
  const buttons = known.map((one, place) => el("button", { type: "button", "aria-pressed": "false", onclick: () => choose(place) }, one.name));
  function choose(chosen) {
    buttons.forEach((button, place) => button.setAttribute("aria-pressed", place === chosen));
    groups.forEach((group, place) => group.querySelectorAll(".other").forEach((each) => each.classList.toggle("chosen", place === chosen)));
    groups[chosen].parentNode.append(groups[chosen]);
  }
  choose(0);
  const rows = known.flatMap((one) => one.points.map((point) => [one.name, point.h, point.e]));
  return el("div", {}, el("div", { class: "legend", role: "group", "aria-label": "highlight" }, buttons),
    figure(drawn, caption, ["", xLabel, yLabel], rows));
}

/** Draw the density of a coordinate under the stationary law of a scheme beside that of the equation. */
function density(one) {
  const label = `stationary ${one.quantity} under ${one.scheme} on ${one.problem}`;
  const x = scaleOf(one.at, LEFT, WIDTH - RIGHT, { log: false }), y = scaleOf([0, ...one.estimate, ...one.exact], HEIGHT - BOTTOM, TOP, { log: false });
  const line = (values, kind) => el("path", { class: kind, d: path(one.at.map((at, place) => [x.at(at), y.at(values[place])])) });
  return figure(picture(label, HEIGHT, [axes(x, y, { x: one.quantity.replace("density of ", ""), y: "density" }), line(one.exact, "exact"), line(one.estimate, "line")]),
    [`Stationary ${one.quantity}: solid under ${one.scheme} at h = ${short(one.h, 4)}, dashed under the equation; the gap is ${short(distance(one), 2)} of the probability.`],
    ["at", "scheme", "equation"], one.at.map((at, place) => [at, one.estimate[place], one.exact[place]]));
}

/** Return half the integral of the absolute difference: the largest difference of probabilities. */
function distance({ at, estimate, exact }) {
  const gaps = at.map((_, place) => Math.abs(estimate[place] - exact[place]));
  return at.slice(1).reduce((sum, right, place) => sum + (right - at[place]) * (gaps[place] + gaps[place + 1]) / 4, 0);
}

/** Draw a row for each name, its marks in the middle of the row, over one axis; return the picture. */
function rowPicture(rows, line, domain, { label, xLabel, marks, ...scale }) {
  const wide = 16 + 6.4 * Math.min(60, Math.max(...rows.map((row) => row.name.length))), width = wide + 380, height = TOP + BOTTOM + line * rows.length, bottom = height - BOTTOM;
  const x = scaleOf(domain, wide + 8, width - RIGHT, scale);
  const grid = x.ticks.map((tick) => [el("line", { class: "grid", x1: x.at(tick), x2: x.at(tick), y1: TOP, y2: bottom }),
    el("text", { class: "soft", x: x.at(tick), y: bottom + 15, "text-anchor": "middle" }, tickText(tick, x.log))]);
  const drawn = rows.map((row, place) => {
    const at = TOP + line * (place + 0.5), name = row.name.length > 60 ? row.name.slice(0, 59) + "…" : row.name;
    return el("g", {}, el("title", {}, row.told), el("text", { x: wide, y: at + 4, "text-anchor": "end" }, name), marks(row, at, x, wide, width));
  });
  return picture(label, height, [...grid.flat(), ...drawn, el("text", { x: (wide + width) / 2, y: height - 6, "text-anchor": "middle" }, xLabel)], width);
}

/** Draw estimates with intervals, a row each: a forest plot. */
function forest(rows, { label, xLabel = "order", caption }) {
  if (!rows.length) return null;
  const values = rows.flatMap((row) => [row.value, row.low, row.high, row.claim, row.least].filter(finite));
  const across = (kind, value, at, x) => finite(value) && el("line", { class: kind, x1: x.at(value), x2: x.at(value), y1: at - 7, y2: at + 7 });
  const marks = (row, at, x) => [finite(row.low) && finite(row.high) && el("line", { class: "bar", x1: x.at(row.low), x2: x.at(row.high), y1: at, y2: at }),
    across("claim", row.claim, at, x), across("least", row.least, at, x),
    finite(row.value) && el("circle", { class: `dot${row.filled ? "" : " hollow"}`, cx: x.at(row.value), cy: at, r: 4, "data-value": row.value })].filter(Boolean);
  return figure(rowPicture(rows, 19, values, { label, xLabel, marks, log: false, least: 0.5 }), caption, ["", xLabel, "from", "to", "claimed"], rows.map((row) => [row.name, row.value, row.low ?? null, row.high ?? null, row.claim ?? null]));
}

/** Draw sets of stable step sizes as bars over a logarithmic axis of h. */
function windows(rows, { label, caption }) {
  const ends = rows.flatMap((row) => row.windows.flat()).filter((h) => finite(h) && h > 0);
  const domain = ends.length ? [...ends, Math.min(...ends) / 4, Math.max(...ends) * 4] : [0.01, 10];
  const clamp = (h, x, wide, width) => Math.max(wide + 8, Math.min(width - RIGHT, h > 0 ? (finite(h) ? x.at(h) : width - RIGHT) : wide + 8));
  const marks = (row, at, x, wide, width) => (!row.windows.length ? el("text", { class: "soft", x: wide + 14, y: at + 4 }, "none") : row.windows.map(([from, to]) => {
    const [left, right] = [from, to].map((h) => clamp(h, x, wide, width));
    return el("rect", { class: "stable", x: left, y: at - 6, height: 12, width: Math.max(2, right - left), "data-from": from, "data-to": to });
  }));
  const told = rows.map((row) => ({ ...row, told: `${row.name}: ${row.text}` }));
  return figure(rowPicture(told, 20, domain, { label, xLabel: "stable step sizes h", marks }), caption, ["", "stable for"], rows.map((row) => [row.name, row.text]));
}

/** Draw a number over eps and h as a map of shaded fields with the number in each. */
function heat(points, { label, caption, yLabel = "eps" }) {
  const hs = [...new Set(points.map((p) => p.h))].sort((a, b) => a - b), es = [...new Set(points.map((p) => p.eps))].sort((a, b) => b - a);
  const most = Math.max(...points.map((p) => p.e)), least = Math.min(...points.map((p) => p.e)), w = 52, line = 20;
  const fields = points.map((p) => {
    const left = LEFT + 10 + w * hs.indexOf(p.h), top = TOP + line * es.indexOf(p.eps);
    const share = most > least ? (p.e - least) / (most - least) : 0;
    return el("g", { class: "heat" }, el("title", {}, `h = ${short(p.h, 4)}, eps = ${short(p.eps, 3)}: ${short(p.e, 4)}`),
      el("rect", { x: left, y: top, width: w - 1, height: line - 1, fill: "var(--accent)", opacity: (0.06 + 0.4 * share).toFixed(3) }),
      el("text", { x: left + w / 2, y: top + 14, "text-anchor": "middle" }, short(p.e, 3)));
  });
  const bottom = TOP + line * es.length, width = LEFT + 20 + w * hs.length;
  const names = [...es.map((eps, place) => el("text", { class: "soft", x: LEFT + 4, y: TOP + line * place + 14, "text-anchor": "end" }, short(eps, 2))),
    ...hs.map((h, place) => el("text", { class: "soft", x: LEFT + 10 + w * (place + 0.5), y: bottom + 14, "text-anchor": "middle" }, short(h, 2)))];
  return figure(picture(label, bottom + 36, [...fields, ...names, el("text", { x: width / 2, y: bottom + 32, "text-anchor": "middle" }, `step size h across, ${yLabel} down`)], Math.max(width, 220)),
    caption, ["h", "eps", "value"], points.map((p) => [p.h, p.eps, p.e]));
}
