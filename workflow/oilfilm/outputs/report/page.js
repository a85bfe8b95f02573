// The explorer of the report: fitted laws with their intervals, points of the logs, the paper's advice.
//
// Laws and intervals are those of oilfilm.fitting.fitted, the advice is that of oilfilm.studies.selection;
// tests/outputs/test_report_browser.py holds both against Python. Names from logs reach the page as text
// only (textContent, Bokeh's escaped tooltips).
"use strict";
(() => {
const read = (id) => JSON.parse(document.getElementById(id).textContent);
const DATA = read("explorer-data");
const DOWNLOADS = read("downloads");
const DRAWINGS = read("drawings");
const POINTS_OF_CURVE = 201;
const MANY = 300; // points beside a curve
const byId = (id) => document.getElementById(id);
const numbers = (values) => values.map((value) => value ?? NaN);

// ---------------------------------------------------------------- laws

const sum = (values) => values.reduce((total, value) => total + value, 0);

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

// asked: [P, U, T, S], S not negative; LAWS are written by oilfilm.outputs.report.law_script
function predict(oil, asked) {
  const { tested: point, away } = onLine(oil, asked);
  const logs = oil.inputs.map(({ axis, factor, power, reference }, i) => (
    oil.known[i] ? Math.log(factor * point[axis] ** power / reference) : 0));
  const design = [1, ...logs];
  const size = design.length;
  const sizes = [];
  for (let start = 0; start < oil.internal.length; start += size) {
    sizes.push(Math.exp(sum(design.map((value, i) => value * oil.internal[start + i]))));
  }
  const { mu: value, slopes } = LAWS[oil.law](sizes, point[3]);
  const mu = away.length ? NaN : value;
  let reach = NaN;
  if (oil.root) {
    const gradient = slopes.flatMap((slope) => design.map((value) => slope * value));
    const along = oil.root[0].map((_, k) => sum(gradient.map((g, i) => g * oil.root[i][k])));
    reach = DATA.factor * Math.hypot(...along);
  }
  const factor = Math.exp(reach / mu);
  const [lower, upper] = mu > 0 ? [mu / factor, mu * factor] : [mu - reach, mu + reach];
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
const film = (oil) => `mu ${short(oil.mu)}, lambda ${short(oil.lambda, 3)}`;

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
  if (judgement === "no film") return `${sentences[0]} No oil has enough film here (lambda above ${limit}).`;
  sentences.push(advised ? `Advised: ${advised.name}, the first with enough film (${film(advised)}; limit ${limit}).`
    : `None of them has enough film (lambda above ${limit}).`);
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
  listen();
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
