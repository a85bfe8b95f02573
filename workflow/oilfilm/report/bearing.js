// The explorer of the bearing in the report.
//
// It interpolates between the operating points of oilfilm.report.bearing_explorer.
// tests/report/test_bearing_explorer.py holds it against Python.
"use strict";
(() => {
const DATA = JSON.parse(document.getElementById("report-data").textContent).bearing;
if (!DATA) return;
const byId = (id) => document.getElementById(`bearing-${id}`);
const { axes: AXES, fine: FINE, coarse: COARSE, oils: OILS } = DATA;

// Numbers that differ by less, relative, are equal: `oilfilm.base.ties`.
const ROUNDING = 1e-9;
const RAD_S_PER_RPM = Math.PI / 30;

// Load and speed are interpolated on logarithmic axes, the temperature on a linear one.
const SCALES = [Math.log, Math.log, (value) => value];
const square = (value) => Math.max(value, 0) ** 2;
const root = (value) => Math.sqrt(Math.max(value, 0));
const identity = (value) => value;
// How each value is interpolated, and the way back.
const FORMS = {
  torque: [Math.log, Math.exp], torqueLower: [Math.log, Math.exp], torqueUpper: [Math.log, Math.exp],
  slip: [root, square], slipLower: [root, square], slipUpper: [root, square],
  film: [Math.log, Math.exp], share: [identity, identity],
};

// ---------------------------------------------------------------- interpolating

// The corners of the cell around a point, [index, weight] with weights above 0, of levels that rise.
function corners(levels, point) {
  return levels.reduce((cell, axis, i) => {
    const size = axis.length;
    const scaledPoint = SCALES[i](Math.min(Math.max(point[i], axis[0]), axis[size - 1]));
    const above = axis.findIndex((level) => SCALES[i](level) >= scaledPoint);
    const below = Math.max(above - 1, 0);
    const width = SCALES[i](axis[above]) - SCALES[i](axis[below]);
    const share = width > 0 ? (scaledPoint - SCALES[i](axis[below])) / width : 0;
    const ends = [[below, 1 - share], [above, share]].filter(([, weight]) => weight > 0);
    return cell.flatMap(([index, weight]) => ends.map(([end, endWeight]) => [index * size + end, weight * endWeight]));
  }, [[0, 1]]);
}

const mean = (values, cell, form) => cell.reduce((sum, [index, weight]) => sum + weight * form(values[index] ?? NaN), 0);
const isSingle = (values, cell) => cell.every(([index]) => values.single[index] === 1);

// Torque, slip and film of an oil at [load, speed, temperature], with the ends of their intervals. `known` is false
// where the cage may roll or skid at a calculated point of the cell.
function predictBearing(number, point) {
  const onMap = [point[0], point[1], DATA.temperature];
  const [cellOfMap, coarseCell, coarseCellOnMap] = [corners(FINE.levels, onMap), corners(COARSE.levels, point), corners(COARSE.levels, onMap)];
  const [fine, coarse] = [FINE.oils[number], COARSE.oils[number]];
  const isOnMap = point[2] === DATA.temperature;
  const known = isSingle(fine, cellOfMap) && (isOnMap || (isSingle(coarse, coarseCell) && isSingle(coarse, coarseCellOnMap)));
  const values = {};
  for (const [name, [form, back]] of Object.entries(FORMS)) {
    const change = isOnMap ? 0 : mean(coarse[name], coarseCell, form) - mean(coarse[name], coarseCellOnMap, form);
    values[name] = known ? back(mean(fine[name], cellOfMap, form) + change) : NaN;
  }
  return { ...values, known };
}

// Index of the best oil, as `oilfilm.torque.best_oil`; -1 where none has a full film, null where it is not known.
function bestOil(answers) {
  if (answers.some(({ known }) => !known)) return null;
  const best = (hasFilm) => {
    const candidates = answers.map((answer, i) => ({ ...answer, i })).filter(hasFilm);
    const holdingCage = candidates.filter(({ slip }) => slip <= DATA.slipLimit * (1 + ROUNDING));
    const smallest = (oils, name) => oils.reduce((first, next) => (next[name] < first[name] * (1 - ROUNDING) ? next : first)).i;
    if (!candidates.length) return -1;
    return holdingCage.length ? smallest(holdingCage, "torque") : smallest(candidates, "slip");
  };
  const known = best(({ film }) => film > DATA.filmLimit * (1 + ROUNDING));
  const perhaps = best(({ film }) => Number.isNaN(film) || film > DATA.filmLimit * (1 + ROUNDING));
  return known === perhaps ? known : null;
}

// ---------------------------------------------------------------- showing

const point = AXES.map(({ start }) => start);
const threeDigits = (value) => (Math.abs(value) >= 100 ? value.toFixed(0) : Number(value.toPrecision(3)).toString());

// A value above its interval, so that a phone shows all columns.
function withInterval(values) {
  if (!values.every(Number.isFinite)) return ["not known"];
  const [value, lower, upper] = values.map(threeDigits);
  const interval = document.createElement("span");
  interval.className = "unit";
  interval.textContent = `${lower} to ${upper}`;
  return [value, document.createElement("br"), interval];
}

function beyond() {
  return AXES.flatMap(({ label, unit, low, high }, i) => (
    point[i] >= low && point[i] <= high ? [] : [`${label} ${point[i]} ${unit}: calculated from ${low} to ${high} ${unit}`]));
}

function show() {
  const outside = beyond();
  byId("outside").hidden = !outside.length;
  byId("outside").textContent = `Not calculated. ${outside.join("; ")}.`;
  const answers = OILS.map((_, i) => (outside.length ? { known: false } : predictBearing(i, point)));
  const speed = point[1] * RAD_S_PER_RPM;
  OILS.forEach((_, i) => {
    const { torque, torqueLower, torqueUpper, slip, slipLower, slipUpper } = answers[i];
    const torqueAndEnds = [torque, torqueLower, torqueUpper];
    byId(`torque-${i}`).replaceChildren(...withInterval(torqueAndEnds));
    byId(`loss-${i}`).replaceChildren(...withInterval(torqueAndEnds.map((value) => value * speed)));
    byId(`slip-${i}`).replaceChildren(...withInterval([slip, slipLower, slipUpper].map((value) => 100 * value)));
  });
  const best = outside.length ? null : bestOil(answers);
  const total = answers.reduce((sum, { share }) => sum + Math.max(share, 0), 0);
  const share = best === null || best < 0 ? NaN : 100 * Math.max(answers[best].share, 0) / total;
  const inDraws = Number.isFinite(share) ? `, in ${share.toFixed(0)} % of the draws` : "";
  byId("best").textContent = best === null ? "Best oil: not known here" : best < 0 ? "Best oil: none has a full film"
    : `Best oil: ${OILS[best]}${inDraws}`;
  const undecided = OILS.filter((_, i) => !outside.length && !answers[i].known);
  byId("not-interpolated").hidden = !undecided.length;
  byId("not-interpolated").textContent = `Not interpolated for ${undecided.join(", ")}: near this point the cage may roll or skid, or the answer has no interval. The command below calculates it.`;
  byId("command").textContent = `oilfilm bearing --bearing ${DATA.bearing} --load ${point[0]}N --speed ${point[1]}rpm --temperature ${point[2]}degC --results results/${DATA.campaign}`;
  AXES.forEach(({ name, unit }, i) => {
    byId(`slider-${name}`).value = point[i];
    byId(`slider-${name}`).setAttribute("aria-valuetext", `${point[i]} ${unit}`);
    byId(`value-${name}`).value = point[i];
  });
}

AXES.forEach(({ name }, i) => {
  const listen = (id, kind) => byId(`${id}-${name}`).addEventListener(kind, ({ target }) => {
    if (target.value !== "") point[i] = Number(target.value);
    show();
  });
  listen("slider", "input");
  listen("value", "change");
});
show();
globalThis.oilfilmBearing = { DATA, predictBearing, bestOil }; // for the tests
})();
