// The explorer of the fits in the report.
//
// mu and its interval are evaluated by `traction`, which oilfilm.report.explorer writes from the laws;
// tests/report/test_report_browser.py holds it against Python. Names from logs reach the page as text only.
"use strict";
(() => {
const byId = (id) => document.getElementById(id);
const DATA = JSON.parse(byId("report-data").textContent);
const { axes: AXES, oils: OILS } = DATA;
const POINTS = DATA.points.mu.map((mu, k) => ({
  mu,
  half: DATA.points.half[k],
  oil: DATA.points.oil[k],
  run: DATA.points.names[DATA.points.run[k]],
  conditions: DATA.points.axes.map((values) => values[k]),
}));
const POINTS_OF_CURVE = 201;
// A chart with more measured points draws them small.
const MANY_DOTS = 500;

// ---------------------------------------------------------------- predicting

// Numbers that differ by less, relative, are equal: `oilfilm.base.ties`.
const ROUNDING = 1e-9;

// The conditions of a law and S, with those that a fit does not follow at their tested level or line, and
// whether they are away from there. A slider that no oil follows changes nothing.
function onLine(oil, asked) {
  const tested = [...asked];
  let away = false;
  const columnOf = (condition) => oil.conditions.indexOf(condition);
  for (const { condition, level, within, least_size: leastSize, in_step: others } of oil.fixed) {
    const axis = columnOf(condition);
    tested[axis] = others.reduce((value, other) => value * (asked[columnOf(other.condition)] / other.centre) ** other.exponent, level ?? NaN);
    const reach = within * Math.max(Math.abs(tested[axis]), leastSize);
    const near = Math.abs(asked[axis] - tested[axis]) <= reach * (1 + ROUNDING);
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
    Math.max((low ?? NaN) - tested[i], tested[i] - (high ?? NaN)) > ROUNDING * Math.abs(tested[i])));
  const unknown = { mu: NaN, lower: NaN, upper: NaN, bandLower: NaN, bandUpper: NaN };
  const outside = away || beyond.includes(true) || spacings(oil, tested) > 1 + ROUNDING;
  return { ...(away ? unknown : traction(oil, tested)), beyond, away, tested: tested.map((value, i) => onAxis(oil, value, i)), outside };
}

// ---------------------------------------------------------------- drawing

const svgElement = (tag, attributes, ...children) => {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children);
  return element;
};
const threeDigits = (value) => (Number.isFinite(value) ? value.toPrecision(3) : "\u2013");
const shortNumber = (value, digits = 4) => (Number.isFinite(value) ? Number(value.toPrecision(digits)).toString() : "\u2013");

// Round numbers across a range, about five of them.
function ticks(low, high) {
  const rough = (high - low) / 5;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= rough);
  const first = Math.ceil(low / step - ROUNDING);
  const count = Math.floor(high / step + ROUNDING) - first + 1;
  return Array.from({ length: count }, (_, i) => Number(((first + i) * step).toPrecision(6)));
}

// A chart of mu over the slider `along`. Each of `series` has a class, `line` of predictions with x, and `dots`,
// which are measured points.
function chart(series, along) {
  const [width, height] = innerWidth < 600 ? [380, 250] : [760, 400];
  const [left, right, top, bottom] = [66, 10, 10, 44];
  const lines = series.map(({ line }) => line.filter(({ mu }) => Number.isFinite(mu)));
  const dots = series.flatMap((curve) => curve.dots);
  // an interval that runs away must not flatten the curves
  const tops = lines.flat().map(({ mu, bandUpper }) => Math.max(mu, Math.min(bandUpper || 0, 2 * mu)));
  const highestMu = Math.max(1e-6, ...tops, ...dots.map(({ mu }) => mu)) * 1.05;
  const lowestMu = Math.min(0, ...dots.map(({ mu }) => mu));
  const [low, high] = rangeOf(along);
  const x = (value) => left + (width - left - right) * ((value - low) / (high - low));
  const y = (mu) => height - bottom - (height - top - bottom) * ((Math.min(mu, 2 * highestMu) - lowestMu) / (highestMu - lowestMu));
  const path = (points) => (points.length ? `M${points.map(([a, b]) => `${x(a).toFixed(2)} ${y(b).toFixed(2)}`).join("L")}` : "");
  const text = (attributes, words) => svgElement("text", { "text-anchor": "middle", ...attributes }, words);
  const frame = { x: left, y: top, width: width - left - right, height: height - top - bottom };
  const inside = svgElement("g", { "clip-path": "url(#clip)" },
    ...untested(series).map(([from, to]) => svgElement("rect", { ...frame, class: "shade", x: x(from), width: x(to) - x(from) })),
    ...series.map(({ kind }, i) => {
      const band = lines[i].filter(({ bandUpper }) => Number.isFinite(bandUpper));
      const outline = [...band.map((prediction) => [prediction.x, prediction.bandUpper]), ...band.map((prediction) => [prediction.x, prediction.bandLower]).reverse()];
      return svgElement("path", { class: `band ${kind}`, d: path(outline) });
    }),
    ...series.flatMap(({ kind, dots: points }) => points.map(({ conditions, mu, half, oil, run }) => svgElement("g", { class: kind },
      svgElement("path", { d: path([[conditions[along], mu - half], [conditions[along], mu + half]]) }),
      svgElement("circle", { cx: x(conditions[along]), cy: y(mu), r: dots.length > MANY_DOTS ? 1.5 : 4 }, svgElement("title", {}, `${oil}, ${run}\n${
        AXES.map(({ symbol, unit }, i) => `${symbol} ${shortNumber(conditions[i] ?? NaN)} ${unit}`).join(", ")}\n\u03bc ${shortNumber(mu)}`))))),
    ...series.map(({ kind }, i) => svgElement("path", { class: `line ${kind}`, d: path(lines[i].map((prediction) => [prediction.x, prediction.mu])) })),
    svgElement("path", { class: "cursor", d: `M${x(state.point[along])} ${top}V${height - bottom}` }));
  const label = "Traction coefficient of the chosen oils; the cards have the numbers";
  return svgElement("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": label },
    svgElement("clipPath", { id: "clip" }, svgElement("rect", frame)), inside,
    svgElement("path", { class: "axis", d: `M${left} ${top}V${height - bottom}H${width - right}` }),
    ...ticks(low, high).flatMap((value) => [svgElement("path", { class: "axis", d: `M${x(value)} ${height - bottom}v5` }),
      text({ x: x(value), y: height - bottom + 19 }, shortNumber(value))]),
    ...ticks(lowestMu, highestMu).flatMap((mu) => [svgElement("path", { class: "axis", d: `M${left} ${y(mu)}h-5` }),
      text({ x: left - 8, y: y(mu) + 4, "text-anchor": "end" }, shortNumber(mu))]),
    text({ x: (left + width - right) / 2, y: height - 6 },
      `${AXES[along].label} ${AXES[along].symbol}${AXES[along].unit && ` (${AXES[along].unit})`}`),
    text({ transform: `translate(14 ${(height - bottom) / 2}) rotate(-90)` }, "Traction coefficient \u03bc"));
}

const line = (oil, point, along, [low, high]) => Array.from({ length: POINTS_OF_CURVE }, (_, i) => {
  const x = low + (high - low) * (i / (POINTS_OF_CURVE - 1));
  return { x, ...predict(oil, point.with(along, x)) };
});

// ---------------------------------------------------------------- explorer

const valueAtStep = (axis, step) => Number((axis.low + Math.min(axis.steps, Math.max(0, step)) * axis.step).toFixed(axis.digits));
const stepOf = (axis, value) => Math.round((value - axis.low) / axis.step);
const state = { x: "S", oils: OILS.map((_, i) => i), point: AXES.map((axis) => valueAtStep(axis, stepOf(axis, axis.start))) };
const abscissa = () => AXES.findIndex(({ symbol }) => symbol === state.x);
const rangeOf = (along) => [AXES[along].low, AXES[along].high];

// The points of an oil whose conditions but the abscissa are near the sliders.
function nearby(oil, along) {
  const isNear = (value, { nearby: width, relative }, i) => (
    Math.abs(value - state.point[i]) <= (relative ? width * state.point[i] : width));
  return POINTS.filter((point) => point.oil === oil.name && point.conditions[along] !== null && point.mu !== null
    && AXES.every((axis, i) => i === along || !(oil.known[i] ?? true) || isNear(point.conditions[i], axis, i)));
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

function drawChart() {
  const along = abscissa();
  const series = state.oils.map((i) => ({
    kind: `oil${i}`,
    line: line(OILS[i], state.point, along, rangeOf(along)),
    dots: nearby(OILS[i], along),
  }));
  const count = series.reduce((sum, { dots }) => sum + dots.length, 0);
  byId("chart").replaceChildren(chart(series, along));
  byId("chart-note").textContent = `${count || "No"} points of the logs near this operating point. Coloured bands: the curve of the next good run. Grey: not tested. Dashed: the chosen point.`;
}

function updateCards() {
  byId("here").textContent = `At ${AXES.flatMap((axis, i) => (axis.idle ? []
    : [`${axis.symbol} ${state.point[i].toFixed(axis.digits)} ${axis.unit}`.trim()])).join(", ")}`;
  const outsideOils = [];
  const overLimitOils = [];
  for (const box of document.getElementsByName("oil")) {
    const oil = OILS[Number(box.value)];
    const { mu, lower, upper, beyond, away, tested, outside } = predict(oil, state.point);
    const card = box.closest(".card");
    card.querySelector(".mu bdi").textContent = away ? "not known here" : threeDigits(mu);
    card.querySelector(".interval bdi").textContent = Number.isFinite(upper) ? `${threeDigits(lower)} to ${threeDigits(upper)} (${
      shortNumber(100 * oil.level, 2)} %)` : "not known";
    card.classList.toggle("beyond", outside);
    const reasons = AXES.flatMap(({ symbol, idle }, k) => (beyond[k] ? [`${symbol} ${idle ? shortNumber(tested[k]) : state.point[k]}: tested ${
      oil.box[k].map((end) => shortNumber(onAxis(oil, end, k), 3)).join(" to ")}`] : []));
    if (outside && !away && !reasons.length) reasons.push("not near any tested condition");
    if (box.checked && reasons.length) outsideOils.push(`${oil.name}: ${reasons.join(", ")}`);
    if (box.checked && mu > oil.limit) overLimitOils.push(`${oil.name}: more than ${oil.limit}`);
  }
  const sentences = [];
  if (outsideOils.length) sentences.push(`Outside the tested conditions, where the law is a guess: ${outsideOils.join("; ")}.`);
  if (overLimitOils.length) sentences.push(`\u03bc is impossible, because no film carries so much shear stress over pressure: ${overLimitOils.join("; ")}.`);
  byId("outside").hidden = !sentences.length;
  byId("outside").textContent = sentences.join(" ");
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
  drawChart();
  updateCards();
}

// Why a typed value cannot be chosen; empty where it can.
function reasonRefused({ symbol, unit, low, high, digits }, value) {
  const reach = ROUNDING * Math.max(Math.abs(low), Math.abs(high));
  if (value >= low - reach && value <= high + reach) return "";
  const range = `${low.toFixed(digits)} to ${high.toFixed(digits)} ${unit}`.trim();
  const percent = symbol === "S" && value > 1 ? ` Write ${value / 100} for ${value} %.` : "";
  return `${symbol} ${value} is not in the range of this page, ${range}.${percent}`;
}

function showRefusal(reason) {
  byId("refused-value").hidden = !reason;
  byId("refused-value").textContent = reason;
}

function listenToExplorer() {
  const listen = (element, kind, change) => element.addEventListener(kind, ({ target }) => {
    change(target.value);
    update();
  });
  AXES.forEach((axis, i) => {
    listen(byId(`slider-${axis.symbol}`), "input", (value) => {
      showRefusal("");
      state.point[i] = valueAtStep(axis, Number(value));
    });
    listen(byId(`value-${axis.symbol}`), "change", (value) => {
      const reason = value === "" ? "" : reasonRefused(axis, Number(value));
      showRefusal(reason && `${reason} It stays at ${state.point[i].toFixed(axis.digits)}.`);
      if (value !== "" && !reason) state.point[i] = valueAtStep(axis, stepOf(axis, Number(value)));
    });
  });
  listen(byId("abscissa"), "change", (value) => { state.x = value; });
  for (const box of document.getElementsByName("oil")) {
    listen(box, "change", () => {
      state.oils = [...document.querySelectorAll("[name=oil]:checked")].map(({ value }) => Number(value));
    });
  }
  addEventListener("resize", drawChart);
}

// The address #run?name=... leads to the operating point of a run, the mean of its points.
function showRun() {
  const name = new URLSearchParams(location.hash.split("?")[1]).get("name");
  const pointsOfRun = POINTS.filter(({ run }) => run === name);
  if (!pointsOfRun.length) return;
  AXES.slice(0, 3).filter(({ idle }) => !idle).forEach((axis) => {
    const i = AXES.indexOf(axis);
    state.point[i] = valueAtStep(axis, stepOf(axis, pointsOfRun.reduce((sum, point) => sum + point.conditions[i] / pointsOfRun.length, 0)));
  });
  update();
  byId("answer").scrollIntoView();
}

// ---------------------------------------------------------------- tables

const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
// What a spreadsheet would run as a formula; numbers and intervals may begin with a minus. `csv_text` of Python
// marks every text with a minus, and one that begins with a tab or a line end, which `plain` removes here.
const FORMULA = /^(?:[=+@]|-(?![\d.][-\d.e %\u2026]*$))/i;
// A minus of print makes a number a text in other programs.
const plain = (text) => text.trim().replace(/\s+/g, " ").replaceAll("\u2212", "-");
const csvCell = (text) => quoted(plain(text).replace(FORMULA, "'$&"));
const csv = (table) => [...table.rows].map((row) => (
  [...row.cells].map(({ textContent }) => csvCell(textContent)).join(","))).join("\n");

async function copy(text) {
  if (navigator.clipboard) {
    await navigator.clipboard.writeText(text);
    return;
  }
  // a browser that takes files for unsafe has the old way only
  const area = document.createElement("textarea");
  area.value = text;
  document.body.append(area);
  area.select();
  document.execCommand("copy");
  area.remove();
}

// A button above each table. It needs the script, so that the script makes it.
function addCopyButtons() {
  for (const table of document.querySelectorAll(".scroll > table")) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "copy";
    button.textContent = "Copy as CSV";
    button.setAttribute("aria-describedby", table.caption.id);
    button.addEventListener("click", async () => {
      await copy(csv(table));
      button.textContent = "Copied";
      setTimeout(() => { button.textContent = "Copy as CSV"; }, 2000);
    });
    table.parentElement.before(button);
  }
}

addCopyButtons();
if (OILS.length) {
  listenToExplorer();
  addEventListener("hashchange", showRun);
  update();
  showRun();
}
globalThis.oilfilm = { OILS, state, predict, nearby, line, rangeOf, csv }; // for the tests
})();
