// The explorer of the report: fitted laws with their intervals, points of the logs, the paper's advice.
//
// Laws and intervals are written by oilfilm.report.law_script, the advice is that of oilfilm.paper.selection;
// tests/report/test_report_browser.py holds both against Python. Names from logs reach the page as text
// only (textContent, Bokeh's escaped tooltips).
"use strict";
(() => {
const read = (id) => JSON.parse(document.getElementById(id).textContent);
const DATA = read("explorer-data");
const DOWNLOADS = read("downloads");
const DRAWINGS = read("drawings");
const RUNS = read("run-pages");
const POINTS_OF_CURVE = 201;
const MANY = 300; // points beside a curve
const SEARCHED = 15; // rows of a table with a field to search it, at least
const byId = (id) => document.getElementById(id);
const numbers = (values) => values.map((value) => value ?? NaN);

// ---------------------------------------------------------------- laws

// The point with conditions that a fit does not follow at their tested level or line, and the axes along
// which it lies away from them. A slider that no oil follows asks for nothing.
function onLine(oil, point) {
  const tested = [...point];
  const away = [];
  for (const { axis, level, within, least_size: least, in_step: others } of oil.fixed) {
    tested[axis] = others.reduce((value, other) => value * (point[other.axis] / other.centre) ** other.exponent, level ?? NaN);
    const near = Math.abs(point[axis] - tested[axis]) <= within * Math.max(Math.abs(tested[axis]), least);
    if (!near && !DATA.axes[axis].idle) away.push(axis);
  }
  return { tested, away };
}

// asked: [P, U, T, S], S not negative; `traction` is written by oilfilm.report.law_script
function predict(oil, asked) {
  const { tested: point, away } = onLine(oil, asked);
  const unknown = { mu: NaN, lower: NaN, upper: NaN };
  const { mu, lower, upper } = away.length ? unknown : traction(oil, point);
  const beyond = oil.box.map((ends, i) => {
    if (away.includes(i)) return Infinity;
    const { within, least_size: least } = oil.fixed.find(({ axis }) => axis === i) ?? { within: 0, least_size: 0 };
    const [low, high] = numbers(ends).map((end, upper) => (
      end + (upper ? within : -within) * Math.max(Math.abs(end), least)));
    const off = Math.max(low - point[i], point[i] - high, 0);
    return off <= 1e-9 * Math.abs(point[i]) ? 0 : off / (high - low);
  });
  return { mu, lower, upper, beyond, away: away.length > 0, tested: point, outside: beyond.some((off) => off > 0) };
}

// ---------------------------------------------------------------- film and advice

function lambdaRatio(film, [pressure, speed, temperature, slip]) {
  const axis = DATA.axes[2];
  const step = Math.round((temperature - axis.low) / axis.step);
  const cold = (film.lambda[step] ?? NaN)
    * pressure ** film.pressure_power * speed ** film.speed_power;
  if (!film.loading.length) return cold;
  const loading = (film.loading[step] ?? NaN) * speed ** 2;
  const fit = film.reduction;
  const heating = fit.pressure_factor * (pressure / film.modulus_gpa) * loading ** fit.pressure_power;
  const shear = fit.shear_factor * (1 + fit.slip_factor * slip ** fit.slip_power)
    * loading ** fit.shear_power;
  // nearer to zero the reduction is beyond its range
  return 1 - heating >= fit.least_numerator ? cold * (1 - heating) / (1 + shear) : NaN;
}

function states([pressure, speed, temperature, slip]) {
  const limits = DATA.selection.limits;
  const slipping = slip > limits.slide_roll_ratio;
  return {
    slipping,
    gripping: !slipping,
    light: pressure < limits.light_below_gpa,
    heavy: pressure >= limits.heavy_from_gpa,
    hot: temperature >= limits.hot_from_c,
    fast: speed >= limits.fast_from_m_s,
  };
}

function advise(point) {
  const { rules, indifference, lambda_limit: limit } = DATA.selection;
  const named = new Set(rules.flatMap((rule) => rule.prefer));
  const choices = DATA.oils.filter((oil) => named.has(oil.name) && !oil.usable && oil.film)
    .map((oil) => ({ name: oil.name, mu: predict(oil, point).mu, lambda: lambdaRatio(oil.film, point) }));
  if (choices.length < named.size) {
    const known = choices.map((oil) => oil.name);
    return { lacking: [...named].filter((name) => !known.includes(name)) };
  }
  const enough = choices.filter((oil) => oil.lambda > limit);
  const perhaps = choices.filter((oil) => !(oil.lambda <= limit));
  const preferred = (rule, oils = enough) => (
    rule.prefer.map((name) => oils.find((oil) => oil.name === name)).find(Boolean));
  const now = states(point);
  const applying = rules.filter((rule) => rule.when.every((name) => now[name]));
  if (!applying.length) return { lacking: [], rule: null };
  const rule = applying[0];
  const most = rule.aim === "most traction";
  const merit = (oil) => (most ? oil.mu : -oil.mu);
  const bestOf = (oils) => (
    oils.reduce((leader, oil) => (leader && !(merit(oil) > merit(leader)) ? leader : oil), undefined));
  const best = bestOf(enough);
  const advised = preferred(rule);
  const outside = preferred(rule, perhaps) !== advised || bestOf(perhaps) !== best;
  const ratio = advised ? advised.mu / best.mu : NaN;
  const loss = most ? 1 - ratio : ratio - 1;
  const judgement = outside ? "outside the film formula" : !advised ? (best ? "rule has none" : "no film")
    : loss <= indifference ? "agree" : "disagree";
  const contradicting = applying.filter((other) => preferred(other) !== advised);
  return { lacking: [], rule, advised, best, loss, judgement, contradicting };
}

const short = (value, digits = 4) => (Number.isNaN(value) ? "\u2013" : Number(value.toPrecision(digits)).toString());
const film = (oil) => `\u03bc ${short(oil.mu)}, \u03bb ${short(oil.lambda, 3)}`;

function adviceSentences(point) {
  if (point[3] === 0) return "Without slip no oil has traction: there is nothing to choose.";
  const advice = advise(point);
  if (advice.lacking.length) {
    return `No advice: the rules name ${advice.lacking.join(", ")}, of which law or film is not known here.`;
  }
  if (!advice.rule) return "No rule of the paper applies here.";
  const { rule, advised, best, judgement } = advice;
  const limit = DATA.selection.lambda_limit;
  const sentences = [`Rule "${rule.name}" (section ${rule.section} of the paper) decides. Aim: ${
    rule.aim}. Order of preference: ${rule.prefer.join(", ")}.`];
  if (judgement === "outside the film formula") {
    return `${sentences[0]} The choice depends on a film beyond the range of the thermal reduction: no advice.`;
  }
  if (judgement === "no film") return `${sentences[0]} No oil has enough film here (\u03bb above ${limit}).`;
  sentences.push(advised ? `Advised: ${advised.name}, the first with enough film (${film(advised)}; limit ${limit}).`
    : `None of them has enough film (\u03bb above ${limit}).`);
  if (advised === best) {
    sentences.push(`The numbers agree: of the oils with enough film it has the ${rule.aim}.`);
  } else {
    sentences.push(`By the numbers ${best.name} has the ${rule.aim} (${film(best)})` + (advised
      ? `; ${advised.name} misses that by ${short(100 * advice.loss, 3)} %: they ${judgement} (indifferent up to ${
        100 * DATA.selection.indifference} %).` : "."));
  }
  for (const other of advice.contradicting) {
    sentences.push(`Rule "${other.name}" (section ${other.section}) applies as well and says otherwise.`);
  }
  return sentences.join(" ");
}

// ---------------------------------------------------------------- state

const at = (axis, step) => Number((axis.low + step * axis.step).toFixed(axis.digits));
const stepOf = (axis, value) => Math.min(axis.steps, Math.max(0, Math.round((value - axis.low) / axis.step)));
const state = {
  x: "S",
  oils: DATA.oils.map((_, i) => i),
  point: DATA.axes.map((axis) => at(axis, stepOf(axis, axis.start))),
};

function fragment() {
  const parts = new URLSearchParams({ x: state.x });
  DATA.axes.forEach((axis, i) => parts.set(axis.symbol, state.point[i]));
  parts.set("oils", JSON.stringify(state.oils.map((i) => DATA.oils[i].name)));
  return `#explorer?${parts}`;
}

// What the address says; parts that make no sense are left as they are.
function restore() {
  const [section, query] = location.hash.slice(1).split("?");
  if (section !== "explorer" || !query) return false;
  const parts = new URLSearchParams(query);
  if (DATA.axes.some((axis) => axis.symbol === parts.get("x") && !axis.idle)) state.x = parts.get("x");
  DATA.axes.forEach((axis, i) => {
    const value = parseFloat(parts.get(axis.symbol));
    if (Number.isFinite(value)) state.point[i] = at(axis, stepOf(axis, value));
  });
  try {
    const names = JSON.parse(parts.get("oils"));
    state.oils = DATA.oils.flatMap((oil, i) => (names.includes(oil.name) ? [i] : []));
  } catch { /* the oils stay */ }
  return true;
}

// ---------------------------------------------------------------- curve

const abscissa = () => DATA.axes.findIndex((axis) => axis.symbol === state.x);

function curve(oil) {
  const [point, along] = [[...state.point], abscissa()];
  const { low, high } = DATA.axes[along];
  return Array.from({ length: POINTS_OF_CURVE }, (_, i) => {
    point[along] = low + (high - low) * (i / (POINTS_OF_CURVE - 1));
    return { x: point[along], ...predict(oil, point) };
  });
}

// Numbers of the points whose conditions but the abscissa are near those of the sliders.
function nearby(oil) {
  const along = abscissa();
  const near = DATA.axes.map((axis, i) => {
    const width = axis.relative ? axis.nearby * state.point[i] : axis.nearby;
    const values = oil.points[axis.name];
    return (k) => i === along || !(oil.known[i] ?? true) || Math.abs(values[k] - state.point[i]) <= width;
  });
  return oil.points.run.flatMap((_, k) => (near.every((test) => test(k)) ? [k] : []));
}

const escapeCell = (cell) => {
  const text = typeof cell === "string" && /^[=+\-@\t\r]/.test(cell) ? `'${cell}` : String(cell);
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
};

function curveAsCsv() {
  const along = abscissa();
  const rows = [["oil", ...DATA.axes.map((axis) => axis.name), "traction_coefficient", "lower", "upper", "outside"]];
  for (const i of state.oils) {
    for (const { x, mu, lower, upper, outside, away, tested } of curve(DATA.oils[i])) {
      const asked = state.point.map((value, k) => (k === along ? x : value));
      const point = away ? asked : tested.map((value) => (Number.isNaN(value) ? "" : value));
      const values = [mu, lower, upper].map((value) => (Number.isNaN(value) ? "" : value));
      rows.push([DATA.oils[i].name, ...point, ...values, outside ? "True" : "False"]);
    }
  }
  return rows.map((row) => `${row.map(escapeCell).join(",")}\r\n`).join("");
}

// ---------------------------------------------------------------- page

// The part of the curve that some oil shown was tested at; none of it where the sliders lie beyond.
function testedAlong(along) {
  const { low, high } = DATA.axes[along];
  const within = state.oils.map((i) => DATA.oils[i]).filter((oil) => (
    predict(oil, state.point).beyond.every((off, k) => k === along || !(off > 0))));
  if (state.oils.length && !within.length) return [high, high];
  const ends = within.map((oil) => numbers(oil.box[along])).filter((pair) => !pair.some(Number.isNaN));
  if (!ends.length) return [low, high];
  return [Math.min(...ends.map((pair) => pair[0])), Math.max(...ends.map((pair) => pair[1]))];
}

let model = (name) => null; // of the chart, once it is there

function draw() {
  const along = abscissa();
  const axis = DATA.axes[along];
  let top = 0;
  let shown = 0;
  DATA.oils.forEach((oil, i) => {
    const on = state.oils.includes(i);
    const line = on ? curve(oil) : [];
    const columns = ["x", "mu", "lower", "upper"].map((name) => [name, line.map((point) => point[name])]);
    model(`curve${i}`).data = Object.fromEntries(columns);
    const near = on ? nearby(oil) : [];
    const { traction_coefficient: mu, traction_coefficient_se: error, runs, run } = oil.points;
    const bar = (k, sign) => mu[k] + sign * DATA.factor * (error[k] ?? 0);
    model(`points${i}`).data = {
      x: near.map((k) => oil.points[axis.name][k]),
      mu: near.map((k) => mu[k]),
      lower: near.map((k) => bar(k, -1)),
      upper: near.map((k) => bar(k, 1)),
      run: near.map((k) => runs[run[k]]),
      oil: near.map(() => oil.name),
      at: near.map((k) => DATA.axes.map(({ symbol, name, unit }) => `${symbol} ${short(oil.points[name][k] ?? NaN)} ${unit}`).join(", ")),
    };
    shown += near.length;
    // many points would hide the curve
    for (const name of ["dots", "bars"]) model(`${name}${i}`).level = near.length > MANY ? "underlay" : "glyph";
    // an interval that runs away must not flatten the curves
    for (const { mu: value, upper } of line) {
      if (!Number.isNaN(value)) top = Math.max(top, value, Math.min(upper || 0, 2 * value));
    }
    for (const k of near) top = Math.max(top, mu[k]);
  });
  Object.assign(model("x"), { start: axis.low, end: axis.high });
  Object.assign(model("y"), { start: 0, end: 1.05 * top || 1 });
  model("chart").below[0].axis_label = `${axis.label} ${axis.symbol}${axis.unit ? ` (${axis.unit})` : ""}`;
  const [low, high] = testedAlong(along);
  Object.assign(model("below"), { left: axis.low, right: Math.max(low, axis.low) });
  Object.assign(model("above"), { left: Math.min(high, axis.high), right: axis.high });
  model("sliders").location = state.point[along];
  byId("chart-note").textContent = `${shown || "No"} points of the logs near this operating point. Shaded: outside all tested ranges. Dashed: the sliders.`;
}

function cells(row, values) {
  for (const [text, isHead, kind] of values) {
    const cell = document.createElement(isHead ? "th" : "td");
    if (isHead) cell.scope = "row";
    const bdi = document.createElement("bdi");
    bdi.textContent = text;
    cell.append(bdi);
    cell.className = kind ?? "";
    row.append(cell);
  }
}

const pointText = () => DATA.axes.flatMap((axis, i) => (axis.idle ? []
  : [`${axis.symbol} ${state.point[i].toFixed(axis.digits)} ${axis.unit}`.trim()])).join(", ");

function tell() {
  byId("here-caption").textContent = `At ${pointText()}`;
  const predictions = state.oils.map((i) => ({ oil: DATA.oils[i], ...predict(DATA.oils[i], state.point) }));
  byId("here").tBodies[0].replaceChildren(...predictions.map(({ oil, mu, lower, upper, beyond, away, tested }) => {
    const off = DATA.axes.flatMap((axis, k) => (beyond[k] > 0 ? [axis.symbol] : []));
    const row = document.createElement("tr");
    const values = [mu, lower, upper].map((value) => [short(value), false, "number"]);
    const ratio = oil.film ? lambdaRatio(oil.film, tested) : NaN;
    const where = away ? "not known here" : off.length ? `no: ${off.join(", ")} beyond` : "yes";
    cells(row, [[oil.name, true], ...values, [short(ratio, 3), false, "number"],
      [where, false, where === "yes" ? "good" : "fair"]]);
    return row;
  }));
  const warnings = DATA.axes.flatMap((axis, k) => {
    const off = predictions.filter(({ beyond, away }) => beyond[k] > 0 && !away)
      .map(({ oil, tested }) => [tested[k], `${short(oil.box[k][0], 3)} to ${short(oil.box[k][1], 3)} (${oil.name})`]);
    const value = axis.idle && off.length ? short(off[0][0]) : state.point[k];
    return off.length ? [`${axis.symbol} ${value}, tested ${off.map(([, range]) => range).join(", ")}`] : [];
  });
  byId("outside").hidden = !warnings.length;
  byId("outside").textContent = warnings.length
    ? `Outside the tested box, where the law is a guess: ${warnings.join("; ")}.` : "";
  byId("advice").textContent = adviceSentences(state.point);
}

function showControls() {
  byId("abscissa").value = state.x;
  DATA.axes.forEach((axis, i) => {
    const slider = byId(`slider-${axis.symbol}`);
    slider.value = stepOf(axis, state.point[i]);
    slider.setAttribute("aria-valuetext", `${state.point[i]} ${axis.unit}`);
    byId(`value-${axis.symbol}`).value = state.point[i].toFixed(axis.digits);
  });
  for (const box of document.getElementsByName("oil")) box.checked = state.oils.includes(Number(box.value));
}

function update({ keepAddress = false } = {}) {
  showControls();
  draw();
  tell();
  if (keepAddress) return;
  try {
    history.replaceState(null, "", fragment());
  } catch { /* a browser that allows no more of them for now; the next one will do */ }
}

// ---------------------------------------------------------------- saving and copying

const KINDS = { csv: "text/csv;charset=utf-8", json: "application/json", svg: "image/svg+xml" };

function save(name, content) {
  const link = document.createElement("a");
  const kind = name.split(".").pop();
  // without the mark some spreadsheets take UTF-8 for another encoding
  const parts = kind === "csv" ? ["\ufeff", content] : [content];
  link.href = URL.createObjectURL(new Blob(parts, { type: KINDS[kind] }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

async function saveDrawing(name) {
  const packed = Uint8Array.from(atob(DRAWINGS[name]), (letter) => letter.charCodeAt(0));
  const unpacked = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  save(`${name}.svg`, await new Response(unpacked).arrayBuffer());
}

async function copy(text, status) {
  try {
    await navigator.clipboard.writeText(text);
    status.textContent = "Copied.";
  } catch {
    status.textContent = "This browser does not let a page copy; save the file instead.";
  }
}

function listen() {
  for (const button of document.querySelectorAll("[data-save]")) {
    button.addEventListener("click", () => save(button.dataset.save, DOWNLOADS[button.dataset.save]));
  }
  for (const button of document.querySelectorAll("[data-drawing]")) {
    button.addEventListener("click", () => saveDrawing(button.dataset.drawing));
  }
  for (const button of document.querySelectorAll("[data-copy]")) {
    button.addEventListener("click", () => copy(DOWNLOADS[button.dataset.copy], byId("copied")));
  }
  // what is folded away would be missing on paper
  let folded = [];
  addEventListener("beforeprint", () => {
    folded = [...document.querySelectorAll("details:not([open], .on-screen)")];
    for (const details of folded) details.open = true;
  });
  addEventListener("afterprint", () => { for (const details of folded) details.open = false; });
}

// ---------------------------------------------------------------- tables

const cellText = (row, column) => row.cells[column].textContent.trim();
// "\u22120.03", "4.3 %" and "31 of 31" are sorted as numbers, all else as text; what is none comes last
const valueOf = (text) => parseFloat(text.replaceAll("\u2212", "-"));

function sortTable(table, column) {
  const head = table.tHead.rows[0].cells[column];
  const down = head.getAttribute("aria-sort") === "ascending";
  for (const cell of table.tHead.rows[0].cells) cell.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", down ? "descending" : "ascending");
  const rows = [...table.tBodies[0].rows];
  const texts = rows.map((row) => cellText(row, column));
  const known = texts.filter((text) => text && text !== "\u2013");
  const numeric = known.every((text) => /^[\u2212+-]?[\d.]+(e[\u2212+-]?\d+)?( %| of \d+)?$/.test(text));
  const key = (row) => {
    const text = cellText(row, column);
    return text === "\u2013" ? "" : text;
  };
  rows.sort((one, other) => {
    const [a, b] = [key(one), key(other)];
    if (!a || !b) return (a ? 0 : 1) - (b ? 0 : 1);
    const order = numeric ? valueOf(a) - valueOf(b) : a.localeCompare(b, "en", { numeric: true });
    return down ? -order : order;
  });
  table.tBodies[0].append(...rows);
}

function searchOf(table) {
  const label = document.createElement("label");
  const input = Object.assign(document.createElement("input"), { type: "search" });
  const status = document.createElement("span");
  status.setAttribute("role", "status");
  label.className = "search";
  const about = Object.assign(document.createElement("span"), { className: "only-heard" });
  about.textContent = `: ${table.caption.textContent}`;
  label.append("Search this table", about, input, status);
  input.addEventListener("input", () => {
    const wanted = input.value.toLowerCase().split(/\s+/);
    let shown = 0;
    for (const row of table.tBodies[0].rows) {
      const text = row.textContent.toLowerCase();
      row.hidden = !wanted.every((word) => text.includes(word));
      shown += !row.hidden;
    }
    status.textContent = input.value ? `${shown} of ${table.tBodies[0].rows.length} rows` : "";
  });
  return label;
}

function listenToTables() {
  for (const table of document.querySelectorAll("main table[role=table]")) {
    const rows = table.tBodies[0].rows.length;
    if (rows < 3) continue;
    [...table.tHead.rows[0].cells].forEach((cell, column) => {
      const button = Object.assign(document.createElement("button"), { type: "button", className: "sort" });
      button.append(...cell.childNodes);
      button.addEventListener("click", () => sortTable(table, column));
      cell.append(button);
    });
    if (rows >= SEARCHED) {
      table.closest(".scroll").before(searchOf(table));
    }
  }
}

// ---------------------------------------------------------------- figures and runs, enlarged

function enlarge(figure) {
  const dialog = byId("enlarged");
  const image = figure.querySelector(".enlarge img").cloneNode();
  image.removeAttribute("width");
  image.removeAttribute("height");
  dialog.querySelector(".picture").replaceChildren(image);
  byId("enlarged-caption").replaceChildren(...figure.querySelector("figcaption p").cloneNode(true).childNodes);
  if (!dialog.open) dialog.showModal();
}

function listenToFigures() {
  const figures = [...document.querySelectorAll("figure:has(.enlarge)")];
  const dialog = byId("enlarged");
  let current = 0;
  const show = (number) => {
    current = (number + figures.length) % figures.length;
    enlarge(figures[current]);
  };
  figures.forEach((figure, number) => figure.querySelector(".enlarge").addEventListener("click", () => show(number)));
  listenToDialog(dialog, (step) => show(current + step));
}

function listenToDialog(dialog, go) {
  for (const button of dialog.querySelectorAll("[data-step]")) {
    button.addEventListener("click", () => go(Number(button.dataset.step)));
  }
  dialog.querySelector("[data-close]").addEventListener("click", () => dialog.close());
  dialog.addEventListener("click", (event) => { if (event.target === dialog) dialog.close(); });
  dialog.addEventListener("keydown", (event) => {
    if (event.key === "ArrowLeft") go(-1);
    if (event.key === "ArrowRight") go(1);
  });
}

function element(name, text, kind) {
  const made = document.createElement(name);
  made.textContent = text;
  if (kind) made.className = kind;
  return made;
}

function tableOf(heading, rows) {
  const table = document.createElement("table");
  table.append(element("caption", heading));
  const body = table.createTBody();
  for (const [name, text, kind] of rows) cells(body.insertRow(), [[name, true], [text, false, kind]]);
  return table;
}

function shape(name, attributes, text = "") {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.textContent = text;
  return made;
}

// Round numbers across a range, about five of them.
function ticks(low, high) {
  const rough = (high - low) / 5;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((size) => size >= rough);
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => Number(((first + i) * step).toPrecision(6)));
}

function curveOfRun(run) {
  const [width, height, left, bottom] = [640, 380, 70, 50];
  const svg = shape("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `Traction curve of ${run.name}` });
  const known = run.S.flatMap((s, k) => (s === null || run.mu[k] === null ? [] : [k]));
  if (!known.length) return element("p", "No plateau of this run has a traction coefficient.");
  const oil = DATA.oils.find((one) => one.name === run.oil);
  const kept = known.filter((k) => run.accepted[k] === "1");
  const slips = known.map((k) => run.S[k]);
  const [low, high] = [Math.min(0, ...slips), Math.max(...slips, 1e-6)];
  const line = oil && run.condition.every((value, axis) => value !== null || DATA.axes[axis].idle)
    ? Array.from({ length: 101 }, (_, i) => high * (i / 100)).map((s) => [s, predict(oil, [...run.condition, s]).mu]).filter(([, mu]) => Number.isFinite(mu))
    : [];
  const values = [...known.map((k) => run.mu[k]), ...line.map(([, mu]) => mu)];
  const [least, most] = [Math.min(0, ...values), Math.max(...values, 1e-6)];
  const x = (s) => left + (width - left - 10) * ((s - low) / (high - low));
  const y = (mu) => height - bottom - (height - bottom - 12) * ((mu - least) / (1.05 * (most - least)));
  svg.append(shape("path", { class: "axis", d: `M${left} 12V${height - bottom}H${width - 10}` }));
  for (const s of ticks(low, high)) {
    svg.append(shape("path", { class: "axis", d: `M${x(s)} ${height - bottom}v5` }),
      shape("text", { x: x(s), y: height - bottom + 20, "text-anchor": "middle" }, short(s)));
  }
  for (const mu of ticks(least, most)) {
    svg.append(shape("path", { class: "axis", d: `M${left} ${y(mu)}h-5` }),
      shape("text", { x: left - 8, y: y(mu) + 4, "text-anchor": "end" }, short(mu)));
  }
  svg.append(shape("text", { x: (left + width) / 2, y: height - 8, "text-anchor": "middle" }, "Slide-roll ratio S"),
    shape("text", { transform: `translate(14 ${(height - bottom) / 2}) rotate(-90)`, "text-anchor": "middle" }, "Traction coefficient \u03bc"));
  if (line.length) svg.append(shape("path", { class: "law", d: `M${line.map(([s, mu]) => `${x(s)} ${y(mu)}`).join("L")}` }));
  for (const k of known) {
    const [px, py] = [x(run.S[k]), y(run.mu[k])];
    if (run.accepted[k] === "1") {
      const reach = DATA.factor * (run.se[k] ?? 0);
      svg.append(shape("path", { class: "error", d: `M${px} ${y(run.mu[k] - reach)}V${y(run.mu[k] + reach)}` }),
        shape("circle", { class: "kept", cx: px, cy: py, r: 4 }));
    } else svg.append(shape("path", { class: "refused", d: `M${px - 4} ${py - 4}l8 8m0 -8l-8 8` }));
  }
  const frame = document.createElement("div");
  const parts = kept.length ? [`Circles: ${kept.length} accepted plateaus with the 95 % interval of their random error.`] : [];
  if (kept.length < known.length) parts.push(`Crosses: ${known.length - kept.length} refused plateaus.`);
  if (line.length) parts.push("Line: fitted law at the mean condition of the run.");
  frame.append(svg, element("p", parts.join(" "), "note"));
  return frame;
}

function pageOfRun(run) {
  const accepted = run.verdict === "accepted";
  const spoken = (rule) => rule.replaceAll("_", " ");
  const size = run.S.length;
  const gates = RUNS.gates.map((gate) => {
    const points = run.gates[gate] ?? 0;
    const whole = !accepted && gate === run.rule;
    const text = whole ? "refused the run" : points ? `refused ${points} of ${size} plateaus` : "refused nothing";
    return [spoken(gate), text, whole ? "bad" : points ? "fair" : ""];
  });
  const verdict = accepted ? "Accepted." : `Refused (${spoken(run.rule)}): ${run.reason}. ${run.advice}`;
  const page = [element("p", verdict, accepted ? "good" : "bad")];
  if (run.warning) page.push(element("p", `Warning: ${run.warning}`, "warning"));
  const beside = document.createElement("div");
  beside.append(tableOf("Facts", RUNS.facts.map((fact, i) => [fact, run.facts[i]])), tableOf("Gates", gates));
  page.push(curveOfRun(run), beside);
  const signals = run.picture && document.querySelector(`img[data-signals="${CSS.escape(run.picture)}"]`);
  if (signals) {
    const picture = document.createElement("div");
    picture.className = "picture";
    picture.append(signals.cloneNode());
    page.push(picture);
  }
  return page;
}

// The page of a run has the address #run?name=...
function showRun() {
  const [kind, query] = location.hash.slice(1).split("?");
  const dialog = byId("run");
  const number = kind === "run" ? RUNS.runs.findIndex(({ name }) => name === new URLSearchParams(query).get("name")) : -1;
  if (number < 0) {
    if (dialog.open) dialog.close();
    return;
  }
  byId("run-heading").textContent = RUNS.runs[number].name;
  byId("run-page").replaceChildren(...pageOfRun(RUNS.runs[number]));
  if (!dialog.open) dialog.showModal();
}

function listenToRuns() {
  const dialog = byId("run");
  listenToDialog(dialog, (step) => {
    const shown = RUNS.runs.findIndex(({ name }) => name === byId("run-heading").textContent);
    const { name } = RUNS.runs[(shown + step + RUNS.runs.length) % RUNS.runs.length];
    location.hash = `#run?name=${encodeURIComponent(name)}`;
  });
  dialog.addEventListener("close", () => {
    if (location.hash.startsWith("#run?")) history.replaceState(null, "", "#data");
  });
  addEventListener("hashchange", showRun);
  showRun();
}

function listenToExplorer() {
  DATA.axes.forEach((axis, i) => {
    byId(`slider-${axis.symbol}`).addEventListener("input", (event) => {
      state.point[i] = at(axis, Number(event.target.value));
      update();
    });
    byId(`value-${axis.symbol}`).addEventListener("change", (event) => {
      if (event.target.value !== "") state.point[i] = at(axis, stepOf(axis, Number(event.target.value)));
      update();
    });
  });
  byId("abscissa").addEventListener("change", (event) => {
    state.x = event.target.value;
    update();
  });
  for (const box of document.getElementsByName("oil")) {
    box.addEventListener("change", () => {
      state.oils = [...document.querySelectorAll("[name=oil]:checked")].map((checked) => Number(checked.value));
      update();
    });
  }
  byId("copy-link").addEventListener("click", () => copy(location.href.split("#")[0] + fragment(), byId("explorer-status")));
  byId("save-curve").addEventListener("click", () => save("curve.csv", curveAsCsv()));
  addEventListener("hashchange", () => { if (restore()) update({ keepAddress: true }); });
}

async function start() {
  document.documentElement.classList.add("script");
  listen();
  listenToTables();
  listenToFigures();
  listenToRuns();
  if (!DATA.oils.length) return;
  const [view] = await Bokeh.embed.embed_item(read("chart-data"), "chart");
  model = (name) => view.model.document.get_model_by_name(name);
  const asked = restore();
  listenToExplorer();
  update({ keepAddress: true });
  if (asked) byId("explorer").scrollIntoView();
  // for the tests
  byId("explorer").dataset.ready = "";
  globalThis.oilfilm = { DATA, state, predict, advise, lambdaRatio, curveAsCsv, model };
}

start();
})();
