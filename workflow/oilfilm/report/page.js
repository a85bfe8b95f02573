// The report in a browser: the explorer of the fits, pages of runs, tables that sort.
//
// mu and its interval are evaluated by `traction`, which oilfilm.report.explorer writes from the laws;
// tests/report/test_report_browser.py holds it against Python. Names from logs reach the page as text only.
"use strict";
(() => {
const byId = (id) => document.getElementById(id);
const all = (selector, within = document) => [...within.querySelectorAll(selector)];
const DATA = JSON.parse(byId("report-data").textContent);
const { axes: AXES, oils: OILS, points: POINTS, runs: RUNS } = DATA;
const POINTS_OF_CURVE = 201;
const MANY = 500;

// ---------------------------------------------------------------- predicting

// The conditions of a law and S, with those that a fit does not follow at their tested level or line, and
// whether they are away from there. A slider that no oil follows changes nothing.
function onLine(oil, asked) {
  const tested = [...asked];
  let away = false;
  const place = (condition) => oil.conditions.indexOf(condition);
  for (const { condition, level, within, least_size: least, in_step: others } of oil.fixed) {
    const axis = place(condition);
    tested[axis] = others.reduce((value, other) => value * (asked[place(other.condition)] / other.centre) ** other.exponent, level ?? NaN);
    const near = Math.abs(asked[axis] - tested[axis]) <= within * Math.max(Math.abs(tested[axis]), least);
    away ||= !near && !AXES[axis].idle;
  }
  return { tested, away };
}

// Distance to the nearest tested conditions, in units of their largest step; 0 where they are unknown.
function spacings({ lattice, conditions }, tested) {
  if (!lattice.length) return 0;
  const coordinate = ({ log }, value) => (log ? Math.log(value) : value);
  const away = lattice[0].tested.map((_, k) => Math.max(...lattice.map((axis) => (
    Math.abs(coordinate(axis, tested[conditions.indexOf(axis.condition)]) - coordinate(axis, axis.tested[k])) / axis.step))));
  return Math.min(...away);
}

// A condition of a law on the axis of its slider.
const onAxis = ({ inputs }, value, i) => (i in inputs ? (value / inputs[i][0]) ** (1 / inputs[i][1]) : value);

// point: [P, U, T, S], S not negative. `beyond`: whether it is outside the tested box, by axis.
function predict(oil, point) {
  const asked = point.map((value, i) => (i in oil.inputs ? oil.inputs[i][0] * value ** oil.inputs[i][1] : value));
  const { tested, away } = onLine(oil, asked);
  const beyond = oil.box.map(([low, high], i) => (
    Math.max((low ?? NaN) - tested[i], tested[i] - (high ?? NaN)) > 1e-9 * Math.abs(tested[i])));
  const unknown = { mu: NaN, lower: NaN, upper: NaN };
  const outside = away || beyond.includes(true) || spacings(oil, tested) > 1;
  return { ...(away ? unknown : traction(oil, tested)), beyond, away, tested: tested.map((value, i) => onAxis(oil, value, i)), outside };
}

// ---------------------------------------------------------------- drawing

function fill(made, attributes, children) {
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}
const html = (tag, attributes, ...children) => fill(document.createElement(tag), attributes, children);
const shape = (tag, attributes, ...children) => (
  fill(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children));
const three = (value) => (Number.isFinite(value) ? value.toPrecision(3) : "\u2013");
const short = (value, digits = 4) => (Number.isFinite(value) ? Number(value.toPrecision(digits)).toString() : "\u2013");

// Round numbers across a range, about five of them.
function ticks(low, high) {
  const rough = (high - low) / 5;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= rough);
  const first = Math.ceil(low / step - 1e-9);
  const count = Math.floor(high / step + 1e-9) - first + 1;
  return Array.from({ length: count }, (_, i) => Number(((first + i) * step).toPrecision(6)));
}

// A chart of mu. Each of `series` has a class, `line` of predictions with x, and `dots` with x, mu, half, text, refused.
// `shades` are parts of the abscissa; `cursor` is drawn across.
function chart({ label, axis, range, series, shades = [], cursor }) {
  const narrow = innerWidth < 600;
  const [width, height] = narrow ? [380, 250] : [760, 400];
  const [left, right, top, bottom] = [66, 10, 10, 44];
  const lines = series.map(({ line }) => line.filter(({ mu }) => Number.isFinite(mu)));
  const dots = series.flatMap((one) => one.dots);
  // an interval that runs away must not flatten the curves
  const tops = lines.flat().map(({ mu, upper }) => Math.max(mu, Math.min(upper || 0, 2 * mu)));
  const most = Math.max(1e-6, ...tops, ...dots.map(({ mu }) => mu)) * 1.05;
  const least = Math.min(0, ...dots.map(({ mu }) => mu));
  const [low, high] = range;
  const x = (value) => left + (width - left - right) * ((value - low) / (high - low));
  const y = (mu) => height - bottom - (height - top - bottom) * ((Math.min(mu, 2 * most) - least) / (most - least));
  const path = (points) => (points.length ? `M${points.map(([a, b]) => `${x(a).toFixed(2)} ${y(b).toFixed(2)}`).join("L")}` : "");
  const clip = `clip-${label.replace(/\W/g, "")}`;
  const frame = { x: left, y: top, width: width - left - right, height: height - top - bottom };
  const svg = shape("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": label },
    shape("clipPath", { id: clip }, shape("rect", frame)));
  const inside = shape("g", { "clip-path": `url(#${clip})` });
  inside.append(...shades.map(([from, to]) => shape("rect", { ...frame, class: "shade", x: x(from), width: x(to) - x(from) })));
  inside.append(...series.map(({ kind }, i) => {
    const band = lines[i].filter(({ upper }) => Number.isFinite(upper));
    const outline = [...band.map((at) => [at.x, at.upper]), ...band.map((at) => [at.x, at.lower]).reverse()];
    return shape("path", { class: `band ${kind}`, d: path(outline) });
  }));
  const curves = series.map(({ kind }, i) => (
    shape("path", { class: `line ${kind}`, d: path(lines[i].map(({ x: at, mu }) => [at, mu])) })));
  // points by the hundred would cover the curves
  const many = dots.length > MANY;
  if (!many) inside.append(...curves);
  for (const { kind, dots: own } of series) {
    const bars = own.filter(({ half }) => half > 0).map(({ x: at, mu, half }) => path([[at, mu - half], [at, mu + half]]));
    inside.append(shape("path", { class: `bar ${kind}`, d: bars.join("") }));
    inside.append(...own.map(({ x: at, mu, text, refused }) => (refused
      ? shape("path", { class: "refused", d: `M${x(at) - 4} ${y(mu) - 4}l8 8m0 -8l-8 8` }, shape("title", {}, text))
      : shape("circle", { class: `dot ${kind}`, cx: x(at), cy: y(mu), r: many ? 1.5 : 4 }, shape("title", {}, text)))));
  }
  if (many) inside.append(...curves);
  if (cursor !== undefined) inside.append(shape("path", { class: "cursor", d: `M${x(cursor)} ${top}V${height - bottom}` }));
  svg.append(inside, shape("path", { class: "axis", d: `M${left} ${top}V${height - bottom}H${width - right}` }),
    ...ticks(low, high).flatMap((value) => [shape("path", { class: "axis", d: `M${x(value)} ${height - bottom}v5` }),
      shape("text", { x: x(value), y: height - bottom + 19, "text-anchor": "middle" }, short(value))]),
    ...ticks(least, most).flatMap((mu) => [shape("path", { class: "axis", d: `M${left} ${y(mu)}h-5` }),
      shape("text", { x: left - 8, y: y(mu) + 4, "text-anchor": "end" }, short(mu))]),
    shape("text", { x: (left + width - right) / 2, y: height - 6, "text-anchor": "middle" }, axis),
    shape("text", { transform: `translate(14 ${(height - bottom) / 2}) rotate(-90)`, "text-anchor": "middle" }, "Traction coefficient \u03bc"));
  return svg;
}

const named = (axis) => `${axis.label} ${axis.symbol}${axis.unit ? ` (${axis.unit})` : ""}`;
const dot = (k, along) => ({
  x: POINTS.axes[along][k],
  mu: POINTS.mu[k],
  half: POINTS.half[k],
  refused: !POINTS.accepted[k],
  text: `${POINTS.oil[k]}, ${POINTS.names[POINTS.run[k]]}\n${AXES.map(({ symbol, unit }, i) => (
    `${symbol} ${short(POINTS.axes[i][k] ?? NaN)} ${unit}`)).join(", ")}\n\u03bc ${short(POINTS.mu[k])}`,
});
const line = (oil, point, along, [low, high]) => Array.from({ length: POINTS_OF_CURVE }, (_, i) => {
  const x = low + (high - low) * (i / (POINTS_OF_CURVE - 1));
  return { x, ...predict(oil, point.with(along, x)) };
});
const isKnown = (k, along) => POINTS.axes[along][k] !== null && POINTS.mu[k] !== null;

// ---------------------------------------------------------------- explorer

const at = (axis, step) => Number((axis.low + Math.min(axis.steps, Math.max(0, step)) * axis.step).toFixed(axis.digits));
const stepOf = (axis, value) => Math.round((value - axis.low) / axis.step);
const state = { x: "S", oils: OILS.map((_, i) => i), point: AXES.map((axis) => at(axis, stepOf(axis, axis.start))) };
const abscissa = () => AXES.findIndex(({ symbol }) => symbol === state.x);
const rangeOf = (along) => [AXES[along].low, AXES[along].high];

// Numbers of the accepted points of an oil whose conditions but the abscissa are near the sliders.
function nearby(oil, along) {
  const near = (k) => AXES.every(({ nearby: width, relative }, i) => i === along || !(oil.known[i] ?? true)
    || Math.abs(POINTS.axes[i][k] - state.point[i]) <= (relative ? width * state.point[i] : width));
  return POINTS.run.flatMap((_, k) => (POINTS.oil[k] === oil.name && POINTS.accepted[k] && isKnown(k, along) && near(k) ? [k] : []));
}

// The parts of the abscissa at which every oil shown is outside its tested conditions.
function untested(series) {
  const xs = (series[0]?.line ?? []).map(({ x }) => x);
  const half = (xs[1] - xs[0]) / 2;
  const outside = xs.map((_, i) => series.every(({ line }) => line[i].outside));
  const starts = xs.filter((_, i) => outside[i] && !outside[i - 1]);
  const ends = xs.filter((_, i) => outside[i] && !outside[i + 1]);
  return starts.map((start, i) => [Math.max(xs[0], start - half), Math.min(xs.at(-1), ends[i] + half)]);
}

function draw() {
  const along = abscissa();
  const series = state.oils.map((i) => ({
    kind: `oil${i}`,
    line: line(OILS[i], state.point, along, rangeOf(along)),
    dots: nearby(OILS[i], along).map((k) => dot(k, along)),
  }));
  const count = series.reduce((sum, { dots }) => sum + dots.length, 0);
  byId("chart").replaceChildren(chart({
    label: "Traction coefficient of the chosen oils; the cards have the numbers",
    axis: named(AXES[along]),
    range: rangeOf(along),
    series,
    shades: untested(series),
    cursor: state.point[along],
  }));
  byId("chart-note").textContent = `${count || "No"} points of the logs near this operating point. Shaded: not tested. Dashed: the chosen point.`;
}

const pointText = () => AXES.flatMap((axis, i) => (axis.idle ? []
  : [`${axis.symbol} ${state.point[i].toFixed(axis.digits)} ${axis.unit}`.trim()])).join(", ");

function tell() {
  byId("here").textContent = `At ${pointText()}`;
  const warnings = [];
  for (const box of document.getElementsByName("oil")) {
    const oil = OILS[Number(box.value)];
    const { mu, lower, upper, beyond, away, tested, outside } = predict(oil, state.point);
    const card = box.closest(".card");
    card.querySelector(".mu bdi").textContent = away ? "not known here" : three(mu);
    card.querySelector(".interval bdi").textContent = Number.isFinite(upper) ? `${three(lower)} to ${three(upper)} (${
      short(100 * oil.level, 2)} %)` : "not known";
    card.classList.toggle("beyond", outside);
    const reasons = AXES.flatMap(({ symbol, idle }, k) => (beyond[k] ? [`${symbol} ${idle ? short(tested[k]) : state.point[k]}: tested ${
      oil.box[k].map((end) => short(onAxis(oil, end, k), 3)).join(" to ")}`] : []));
    if (outside && !away && !reasons.length) reasons.push("not near any tested condition");
    if (mu > oil.limit) reasons.push(`no film carries more shear stress than ${oil.limit} of the pressure`);
    if (box.checked && reasons.length) warnings.push(`${oil.name}: ${reasons.join(", ")}`);
  }
  byId("outside").hidden = !warnings.length;
  byId("outside").textContent = `Outside the tested conditions, where the law is a guess: ${warnings.join("; ")}.`;
}

function update() {
  byId("abscissa").value = state.x;
  AXES.forEach((axis, i) => {
    const [slider, value] = ["slider", "value"].map((name) => byId(`${name}-${axis.symbol}`));
    slider.value = stepOf(axis, state.point[i]);
    slider.setAttribute("aria-valuetext", `${state.point[i]} ${axis.unit}`);
    value.value = state.point[i].toFixed(axis.digits);
  });
  for (const box of document.getElementsByName("oil")) box.checked = state.oils.includes(Number(box.value));
  draw();
  tell();
}

function listenToExplorer() {
  const listen = (element, kind, change) => element.addEventListener(kind, ({ target }) => {
    change(target.value);
    update();
  });
  AXES.forEach((axis, i) => {
    listen(byId(`slider-${axis.symbol}`), "input", (value) => { state.point[i] = at(axis, Number(value)); });
    listen(byId(`value-${axis.symbol}`), "change", (value) => { if (value !== "") state.point[i] = at(axis, stepOf(axis, Number(value))); });
  });
  listen(byId("abscissa"), "change", (value) => { state.x = value; });
  for (const box of document.getElementsByName("oil")) {
    listen(box, "change", () => { state.oils = all("[name=oil]:checked").map(({ value }) => Number(value)); });
  }
  addEventListener("resize", draw);
}

// ---------------------------------------------------------------- tables

// "\u22120.03", "4.3 %" and "31 of 31" are sorted as numbers, all else as text; texts come last
function order(one, other) {
  const [a, b] = [one, other].map((text) => parseFloat(text.replaceAll("\u2212", "-")));
  return a - b || Number.isNaN(a) - Number.isNaN(b) || one.localeCompare(other, "en", { numeric: true });
}

function sortTable(table, column) {
  const heads = [...table.tHead.rows[0].cells];
  const down = heads[column].getAttribute("aria-sort") === "ascending";
  for (const head of heads) head.removeAttribute("aria-sort");
  heads[column].setAttribute("aria-sort", down ? "descending" : "ascending");
  const text = (row) => row.cells[column].textContent.trim();
  const rows = [...table.tBodies[0].rows].sort((one, other) => order(text(one), text(other)));
  table.tBodies[0].append(...(down ? rows.reverse() : rows));
}

function listenToTables() {
  for (const table of all("main table").filter((one) => one.tBodies[0].rows.length > 2)) {
    [...table.tHead.rows[0].cells].forEach((cell, column) => {
      const button = html("button", { type: "button", class: "sort" }, ...cell.childNodes);
      button.addEventListener("click", () => sortTable(table, column));
      cell.append(button);
    });
  }
}

// ---------------------------------------------------------------- pages of runs

function pageOfRun(run) {
  const own = POINTS.run.flatMap((number, k) => (POINTS.names[number] === run.name && isKnown(k, 3) ? [k] : []));
  const oil = OILS.find(({ name }) => name === run.oil);
  const slips = own.map((k) => POINTS.axes[3][k]);
  const range = [Math.min(0, ...slips), Math.max(1e-6, ...slips)];
  const known = oil && run.condition.every((value, i) => value !== null || AXES[i].idle);
  const law = known ? line(oil, [...run.condition, 0], 3, [0, range[1]]) : [];
  const curve = chart({
    label: `Traction curve of ${run.name}`,
    axis: named(AXES[3]),
    range,
    series: [{ kind: known ? `oil${OILS.indexOf(oil)}` : "", line: law, dots: own.map((k) => dot(k, 3)) }],
  });
  const link = all("#run-list tbody a").find(({ textContent }) => textContent === run.name);
  const heads = [...byId("run-list").tHead.rows[0].cells].slice(1);
  const facts = heads.map((head, i) => html("tr", {}, html("th", { scope: "row" }, head.textContent),
    html("td", {}, link.closest("tr").cells[i + 1].textContent)));
  const image = all("#refused img").find(({ alt }) => alt === `Signals of ${run.name}`);
  return [
    html("p", { class: run.refused ? "bad" : "good" }, run.refused || "Accepted."),
    ...(run.warning ? [html("p", { class: "warning" }, `Warning: ${run.warning}`)] : []),
    html("div", { class: "run" },
      html("div", {}, curve, html("p", { class: "note" }, "Circles: accepted plateaus with the 95 % interval of their random error. "
        + "Crosses: refused plateaus. Line: fitted law at the mean condition of the run.")),
      html("table", {}, html("tbody", {}, ...facts))),
    ...(image ? [image.cloneNode()] : []),
  ];
}

// The page of a run has the address #run?name=...
function listenToDialog() {
  const dialog = byId("dialog");
  const showRun = () => {
    const [kind, query] = location.hash.slice(1).split("?");
    const run = kind === "run" && RUNS.find(({ name }) => name === new URLSearchParams(query).get("name"));
    if (!run) return;
    byId("dialog-heading").textContent = run.name;
    byId("dialog-content").replaceChildren(...pageOfRun(run));
    if (!dialog.open) dialog.showModal();
  };
  dialog.querySelector("button").addEventListener("click", () => dialog.close());
  dialog.addEventListener("close", () => history.replaceState(null, "", "#data"));
  addEventListener("hashchange", showRun);
  showRun();
}

document.documentElement.classList.add("script");
// what is folded away would be missing on paper
let folded = [];
addEventListener("beforeprint", () => {
  folded = all("details:not([open])");
  for (const details of folded) details.open = true;
});
addEventListener("afterprint", () => { for (const details of folded) details.open = false; });
listenToTables();
listenToDialog();
if (OILS.length) {
  listenToExplorer();
  update();
}
globalThis.oilfilm = { OILS, POINTS, state, predict, nearby, abscissa, line, rangeOf }; // for the tests
})();
