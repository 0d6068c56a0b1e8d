"use strict";
// The state of the page is one query, as in its address: what C++ is asked, and what a link brings back.

// A control: {name, kind, first, …}. "range": low, high, step; "log": a power of ten from low to high, and 0 below it
// if `zero`; "choice": words; "hidden": set by the pictures.
const range = (name, low, high, step, first) => ({name, kind: "range", low, high, step, first});
const log = (name, low, high, first, zero = false) => ({name, kind: "log", low, high, first, zero});
const choice = (name, ...words) => ({name, kind: "choice", words, first: words[0]});
const hidden = (name, first) => ({name, kind: "hidden", first});

// What is dragged and clicked in the pictures.
const DRAGGED = ["cameras", "landmarks", "camera_starts", "landmark_starts", "without"];
const SCENE = [
  log("weight", -3, 10, "1", true), choice("gauge", "prior", "minimal", "fixed", "free"),
  choice("motion", "arc", "turn"), range("frames", 2, 10, 1, "3"), range("points", 4, 40, 1, "20"),
  range("noise", 0, 0.02, 0.0005, "0.001"), range("start", 0, 1, 0.02, "0"), choice("information", "unit", "noise"),
  range("outliers", 0, 8, 1, "0"), choice("loss", "none", "huber", "cauchy", "tukey"), range("delta", 0.5, 10, 0.5, "2"),
  choice("damping", "identity", "diagonal"), choice("algorithm", "lm", "gn", "dogleg"),
  ...DRAGGED.map(one => hidden(one, "")),
];
const CONTROLS = {
  solve: [...SCENE, choice("solver", "dense", "blocks", "sparse"), range("iterations", 0, 40, 1, "20"),
    range("seed", 0, 20, 1, "5")],
  steps: [...SCENE, log("tau", -12, 3, "1e-5"), log("radius", -3, 4, "1e4"), hidden("trial", "0"),
    hidden("stop", "linearize")],
  marginalize: [choice("system", "scene", "chain"),
    ...SCENE.filter(one => ["weight", "gauge", "motion", "frames", "points", "noise"].includes(one.name)), hidden("drop", "")],
  window: [range("image", 0, 29, 1, "12"), range("rate", 5, 20, 1, "15"), range("tracks", 6, 30, 1, "12"),
    range("pixels", 0, 5, 0.25, "1")],
  eliminate: [choice("board", "random", "chain", "loop", "grid", "bundle"), range("seed", 0, 30, 1, "3"), hidden("order", "")],
};

// `task` names the open task; `beside` are the settings to compare with, `null` for none; `ignored` what the address asked
// for in vain: [{setting, value, kind, limits}, …].
const state = {panel: "solve", language: "en", values: {}, task: "", beside: null, ignored: []};

const firstValues = panel => Object.fromEntries(CONTROLS[panel].map(one => [one.name, one.first]));

// The settings of the panel that the address does not name are the first ones.
function readAddress() {
  const address = new URLSearchParams(location.hash.slice(1));
  const asked = address.get("lang") || new URLSearchParams(location.search).get("lang");
  state.language = /^zh/.test(asked || (state.read ? state.language : navigator.language)) ? "zh" : "en";
  state.read = true;
  state.ignored = [];
  const asks = address.get("task") ?? "", task = CHALLENGES.find(one => one.id === asks);
  const panel = address.get("panel") ?? (task ? task.panel : "solve");
  state.panel = Object.hasOwn(CONTROLS, panel) ? panel : "solve";
  state.task = task && task.panel === state.panel ? asks : "";
  if (state.panel !== panel) ignore("panel", panel, "one of", Object.keys(CONTROLS).join(", "));
  if (asks && !task) ignore("task", asks, "one of", CHALLENGES.map(one => one.id).join(", "));
  const own = ["panel", "lang", "task", "beside"], first = {...firstValues(state.panel), ...(address.has("panel") ? {} : task?.start)};
  const read = words => ({...first, ...Object.fromEntries([...words].filter(([name]) => !own.includes(name)))});
  state.values = read(address);
  state.beside = address.has("beside") ? read(new URLSearchParams(address.get("beside"))) : null;
}

function ignore(setting, value, kind, limits) { state.ignored.push({setting, value, kind, limits}); }

// What differs from the first values, as in an address.
function changes(panel, values) {
  const first = firstValues(panel), changed = new URLSearchParams();
  for (const [name, value] of Object.entries(values)) if (value !== first[name]) changed.set(name, value);
  return changed;
}

// `undoable`: the browser's Back brings back what was there.
function writeAddress(undoable = false) {
  const address = new URLSearchParams({panel: state.panel});
  for (const [name, value] of changes(state.panel, state.values)) address.set(name, value);
  if (state.beside) address.set("beside", changes(state.panel, state.beside));
  if (state.task) address.set("task", state.task);
  if (new URLSearchParams(location.hash.slice(1)).has("lang")) address.set("lang", state.language);
  history[undoable ? "pushState" : "replaceState"](null, "", "#" + address.toString().replaceAll("%2C", ",").replaceAll("%3A", ":"));
}

// What C++ is asked.
function query(panel = state.panel, values = state.values) {
  return Object.entries({panel, ...values}).filter(([, value]) => value !== "")
    .map(([name, value]) => `${name}=${value.replaceAll("&", "＆")}`).join("&");
}

function text(key) {
  if (!TEXT[key]) throw new Error(`no text for ${key}`);
  return TEXT[key][state.language];
}

// "words {name}" with the value of `values.name`.
function say(key, values = {}) { return text(key).replace(/{(\w+)}/g, (_, name) => values[name]); }

// A logarithmic slider has a place for each tenth of a decade, and one for zero at its foot.
const placeOf = (one, value) => Number(value) > 0 ? Math.round(10 * Math.log10(Number(value))) : 10 * one.low - 1;
function valueAt(one, place) {
  if (place < 10 * one.low) return "0";
  return place % 10 === 0 ? `1e${place / 10}`.replace(/^1e0$/, "1") : (10 ** (place / 10)).toPrecision(3);
}

function control(one, change) {
  const id = `set-${one.name}`, value = state.values[one.name];
  const shown = element("output", {for: id}, one.kind === "choice" ? "" : asPowers(value));
  let input;
  if (one.kind === "choice") {
    input = element("select", {id, change: () => change(one.name, input.value)},
      ...one.words.map(word => element("option", {value: word, selected: word === value}, text(`${one.name}.${word}`))));
  } else {
    const [low, high, step, at] = one.kind === "log"
      ? [10 * one.low - (one.zero ? 1 : 0), 10 * one.high, 1, placeOf(one, value)] : [one.low, one.high, one.step, value];
    const read = () => one.kind === "log" ? valueAt(one, Number(input.value)) : input.value;
    input = element("input", {id, type: "range", min: low, max: high, step, value: at, "aria-valuetext": asPowers(value),
      input: () => {
        shown.textContent = asPowers(read());
        input.setAttribute("aria-valuetext", shown.textContent);
        change(one.name, read());
      }});
  }
  return element("label", {for: id, title: TEXT[`${one.name}.help`] ? text(`${one.name}.help`) : undefined},
    text(one.name), shown, input);
}
