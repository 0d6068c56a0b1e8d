"use strict";
// From a setting to C++ and back to pictures.

let ask = null;  // query → answer, once WebAssembly is there
let flown = "", wait = 0;
const part = id => document.getElementById(id);

function set(values) {
  Object.assign(state.values, values);
  writeAddress();
  show();
}

// Another scene: what was marginalized or stopped at belongs to the one before.
function change(name, value) {
  const reset = state.panel === "marginalize" ? {drop: ""} : state.panel === "steps" ? {trial: "0"} : {};
  set({...reset, [name]: value});
  if (name === "system") {
    build();  // the chain has no settings
    part("set-system").focus();
  }
}

// A new flight takes C++ a second: the page says so first, and of the settings that a slider goes through meanwhile only
// the last ones are flown.
function show() {
  if (!ask) return;
  clearTimeout(wait);
  const {rate, tracks, pixels} = state.values, flight = state.panel === "window" ? `${rate} ${tracks} ${pixels}` : flown;
  part("pictures").setAttribute("aria-busy", String(flight !== flown));
  if (flight === flown) return draw();
  part("status").textContent = text("flying");
  return new Promise(done => { wait = setTimeout(() => { flown = flight; done(show()); }, 50); });
}

function draw() {
  const begin = performance.now();
  const answer = JSON.parse(ask(query()));
  const computed = performance.now();
  part("message").textContent = answer.error || "";
  if (answer.error) return part("pictures").replaceChildren();
  const focused = document.activeElement && document.activeElement.id;
  part("pictures").replaceChildren(...DRAW[state.panel](answer, set).filter(Boolean));
  if (focused && part(focused)) part(focused).focus();
  part("status").textContent = say("time", {all: (performance.now() - begin).toFixed(0), own: (computed - begin).toFixed(0)});
}

function build() {
  document.documentElement.lang = state.language === "zh" ? "zh-Hans" : "en";
  document.title = text("title");
  document.querySelectorAll("[data-text]").forEach(node => { node.textContent = text(node.dataset.text); });
  document.querySelectorAll("[data-label]").forEach(node => node.setAttribute("aria-label", text(node.dataset.label)));
  document.querySelectorAll("[data-language]").forEach(node =>
    node.setAttribute("aria-pressed", String(node.dataset.language === state.language)));
  part("panels").replaceChildren(...Object.keys(CONTROLS).map(one => element("button", {type: "button", role: "tab",
    id: `tab-${one}`, "aria-selected": String(one === state.panel), "aria-controls": "panel",
    tabindex: one === state.panel ? 0 : -1, click: () => open(one)}, text(`panel.${one}`))));
  const known = CONTROLS[state.panel];
  const shown = (known || []).filter(one => one.kind !== "hidden" && !(state.values.system === "chain" && SCENE.includes(one)));
  part("pictures").dataset.panel = state.panel;
  part("panel").setAttribute("aria-labelledby", `tab-${state.panel}`);
  part("words").textContent = known ? text(`words.${state.panel}`) : "";
  part("controls").replaceChildren(...shown.map(one => control(one, change)));
  part("pictures").replaceChildren();
  show();
}

function open(panel) {
  location.hash = `panel=${panel}`;
  part(`tab-${panel}`).focus();
}

part("panels").addEventListener("keydown", event => {
  const by = {ArrowRight: 1, ArrowLeft: -1}[event.key], all = Object.keys(CONTROLS);
  if (!by) return;
  const next = all[(all.indexOf(state.panel) + by + all.length) % all.length];
  open(next);
  addEventListener("hashchange", () => part(`tab-${next}`).focus(), {once: true});
});
part("language").addEventListener("click", event => {
  if (!event.target.dataset.language) return;
  state.language = event.target.dataset.language;
  if (CONTROLS[state.panel]) writeAddress();
  build();
});
part("controls").addEventListener("submit", event => event.preventDefault());
addEventListener("hashchange", () => { readAddress(); build(); });
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", show);

readAddress();
build();
part("status").textContent = text("loading");
const ready = CourseLab().then(lab => {
  ask = words => lab.ccall("LabAnswer", "string", ["string"], [words]);
  return show();
}).catch(error => { part("message").textContent = String(error); });
