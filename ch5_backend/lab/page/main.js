"use strict";
// From a setting to C++ and back to pictures.

const part = id => document.getElementById(id);

function set(values) {
  state.values = {...state.values, ...values};
  writeAddress();
  return show();
}

// Another scene: what was marginalized or stopped at belongs to the one before.
function change(name, value) {
  const reset = {marginalize: {drop: ""}, steps: {trial: "0"}, eliminate: {order: ""}}[state.panel];
  set({...reset, [name]: value});
  if (name === "system") {
    build();  // the chain has no settings
    part("set-system").focus();
  }
}

// A flight is shown while it grows, two images at a time. C++ keeps two flights, and so does this account of them.
const flights = new Map();  // its settings → the last image flown
const flightOf = ({rate, tracks, pixels}) => `${rate} ${tracks} ${pixels}`;

function* stages(panel, values, last = Number(values.image)) {
  if (panel !== "window") return yield {};
  for (let until = (flights.get(flightOf(values)) ?? -2) + 2; until < last; until += 2) yield {until: String(until)};
  yield {until: String(Math.max(last, flights.get(flightOf(values)) ?? 0))};
}

function note(panel, values, {until}) {
  if (!until) return;
  const reached = Math.max(Number(until), flights.get(flightOf(values)) ?? 0);
  flights.delete(flightOf(values));
  flights.set(flightOf(values), reached);
  if (flights.size > 2) flights.delete(flights.keys().next().value);
}

let turn = 0, drawn = 0;

// Asks for the present settings and draws the answers as they come: of settings that a slider goes through faster than
// C++ answers, the last ones.
async function show() {
  const mine = ++turn, {panel, values, beside} = state, isWanted = () => mine === turn, begin = performance.now();
  if (!solver) return;
  const get = async (settings, stage) => {
    const words = await ask(query(panel, {...settings, ...stage}), {isWanted, urgent: true});
    if (words !== null) note(panel, settings, stage);
    return words && JSON.parse(words);
  };
  let other = null;
  for (const stage of beside ? stages(panel, beside) : []) other = await get(beside, stage);
  if (beside && !other) return;
  for (const stage of stages(panel, values)) {
    part("pictures").setAttribute("aria-busy", String(Boolean(stage.until) && Number(stage.until) < Number(values.image)));
    const answer = await get(values, stage);
    if (!answer || mine < drawn || panel !== state.panel) return;
    const fault = answer.error ? [values, answer] : other && other.error ? [beside, other] : null;
    if (fault) return drop(...fault);
    drawn = mine;
    draw(answer, values, other, beside, begin);
    if (!isWanted()) return;
    if (!(Number(stage.until) < Number(values.image))) judge(answer, values);
  }
  if (panel !== "window" || flights.get(flightOf(values)) === 29) return;
  for (const stage of stages(panel, values, 29)) if (!await get(values, stage)) return;  // ready for the next move
}

// A setting that C++ refuses is named, and its first value used.
function drop(values, {setting, value, kind, limits}) {
  ignore(setting, value, kind, limits);
  const first = firstValues(state.panel);
  const {[setting]: _, ...rest} = values;
  const kept = setting in first ? {...rest, [setting]: first[setting]} : setting in values ? rest : first;
  state[values === state.beside ? "beside" : "values"] = kept;
  writeAddress();
  return build();
}

function tellIgnored() {
  part("message").replaceChildren(...state.ignored.map(({setting, value, kind, limits}) => element("span", {},
    say(kind === "setting" ? "ignored.setting" : "ignored", {setting, value,
      wanted: kind === "setting" ? "" : say(`wanted.${kind}`, {limits: asPowers(limits.replace(" to ", " – "))})}), " ")));
}

function draw(answer, values, other, beside, begin) {
  const focused = document.activeElement && document.activeElement.id;
  const veiled = isVeiled(), task = taskNow();
  const place = (box, a, settings, setter) => {
    const drawings = DRAW[state.panel](a, settings, setter).filter(Boolean);
    const isShown = one => !task || (veiled ? task.keep : task.picture).includes(one.dataset.key);
    const rank = one => task?.picture.indexOf(one.dataset.key);
    box.replaceChildren(...drawings.filter(isShown).sort((one, other) => task ? rank(one) - rank(other) : 0));
    if (task && !veiled) box.append(fold(drawings.filter(one => !isShown(one))));
  };
  if (other) {  // drawn once for the ranges, then with what both share
    common = new Map();
    DRAW[state.panel](other, beside, () => {});
  }
  place(part("pictures"), answer, values, set);
  part("beside").hidden = !other;
  part("stage").classList.toggle("two", Boolean(other));
  part("beside").replaceChildren();
  if (other) {
    place(part("beside"), other, beside, () => {});
    common = null;
    freeze(part("beside"));
    part("beside").prepend(element("h2", {class: "wide"}, `${text("beside")}: ${differences(beside, values)}`));
    part("pictures").prepend(element("h2", {class: "wide"}, `${text("now")}: ${differences(values, beside)}`));
  }
  if (veiled) part("pictures").append(element("p", {class: "wide soft", id: "veil"}, text("task.veiled")));
  part("controls").inert = veiled;
  if (focused && part(focused)) part(focused).focus({preventScroll: true});
  part("status").textContent = part("pictures").ariaBusy === "true" ? text("flying")
    : say("time", {all: (performance.now() - begin).toFixed(0)});
}

// What a task does not need.
function fold(drawings) {
  const toggle = event => { state.isUnfolded = event.target.open; };
  return element("details", {class: "wide", open: state.isUnfolded, toggle}, element("summary", {}, text("other.pictures")),
    element("div", {class: "pictures", "data-panel": state.panel}, ...drawings));
}

// What is only to be looked at keeps its place, but no name that another bears.
function freeze(box) {
  for (const node of box.querySelectorAll("[id]")) node.removeAttribute("id");
  for (const node of box.querySelectorAll(".row")) node.style.visibility = "hidden";
  for (const node of box.querySelectorAll("canvas, .handle")) {
    node.removeAttribute("tabindex");
    node.setAttribute("role", "img");
  }
}

// In what the first settings differ from the second.
function differences(values, others) {
  const names = Object.keys(values).filter(one => values[one] !== others[one]);
  return names.map(one => `${TEXT[one] ? text(one) : one} ${TEXT[`${one}.${values[one]}`] ? text(`${one}.${values[one]}`)
    : asPowers(values[one]) || "–"}`).join(text("comma")) || text("same");
}

function build() {
  const task = taskNow();
  document.documentElement.lang = state.language === "zh" ? "zh-Hans" : "en";
  document.title = text("title");
  document.querySelectorAll("[data-text]").forEach(node => { node.textContent = text(node.dataset.text); });
  document.querySelectorAll("[data-label]").forEach(node => node.setAttribute("aria-label", text(node.dataset.label)));
  document.querySelectorAll("[data-language]").forEach(node =>
    node.setAttribute("aria-pressed", String(node.dataset.language === state.language)));
  part("panels").replaceChildren(...Object.keys(CONTROLS).map(one => element("button", {type: "button", role: "tab",
    id: `tab-${one}`, "aria-selected": String(one === state.panel), "aria-controls": "panel",
    tabindex: one === state.panel ? 0 : -1, click: () => open(one)}, text(`panel.${one}`))));
  const shown = CONTROLS[state.panel].filter(one => one.kind !== "hidden"
    && !(state.values.system === "chain" && SCENE.includes(one)));
  part("pictures").dataset.panel = part("beside").dataset.panel = state.panel;
  part("panel").setAttribute("aria-labelledby", `tab-${state.panel}`);
  part("words").textContent = text(`words.${state.panel}`);
  part("controls").replaceChildren(...shown.filter(one => one.name !== task?.control).map(one => control(one, change)));
  part("task-control").replaceChildren(...shown.filter(one => one.name === task?.control && !isVeiled()).map(one => control(one, change)));
  part("others").open = !task;
  state.isUnfolded = false;
  document.body.classList.toggle("tasking", Boolean(task));
  part("compare").setAttribute("aria-pressed", String(Boolean(state.beside)));
  part("help-words").replaceChildren(...text("help.words").split("\n").map(one => element("li", {}, one)));
  tellIgnored();
  drawTasks();
  return show();
}

// Each panel is found again as it was left.
const addresses = {};

function open(panel) {
  addresses[state.panel] = location.hash;
  location.hash = addresses[panel] ?? `panel=${panel}`;
  part(`tab-${panel}`).focus();
}

function reset() {
  const task = taskNow();
  Object.assign(state, {values: {...firstValues(state.panel), ...(task ? task.start : {})}, beside: null, ignored: []});
  writeAddress(true);
  build();
}

function compare() {
  state.beside = state.beside ? null : state.values;
  writeAddress();
  build();
}

const help = () => part("help").open ? part("help").close() : part("help").showModal();
const tasks = () => openTask(state.task ? "" : CHALLENGES.find(one => !kept.solved.includes(one.id))?.id ?? CHALLENGES[0].id);

// One key each, as the help says; not while a dialog or a modifier asks for it.
const KEYS = {r: reset, c: compare, t: tasks, "?": help, ...Object.fromEntries(Object.keys(CONTROLS).map((panel, i) =>
  [String(i + 1), () => open(panel)]))};
addEventListener("keydown", event => {
  if (!KEYS[event.key] || event.ctrlKey || event.altKey || event.metaKey || event.target.tagName === "SELECT") return;
  if (!kept.keys || (part("help").open && event.key !== "?")) return;
  event.preventDefault();
  KEYS[event.key]();
});

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
  writeAddress();
  build();
});
// Past the settings and the scene's handles, each of which stops the Tab key.
const skip = () => (document.querySelector("#pictures [id^=matrix-]") ?? part("panel")).focus();
for (const [id, act] of Object.entries({skip, reset, compare, "show-help": help, "close-help": help})) {
  part(id).addEventListener("click", act);
}
part("keys").checked = kept.keys;
part("keys").addEventListener("change", () => { kept.keys = part("keys").checked; keep(); });
part("controls").addEventListener("submit", event => event.preventDefault());
addEventListener("hashchange", () => { readAddress(); build(); });
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", show);

readAddress();
build();
part("status").textContent = text("loading");
const ready = startSolver().then(show).catch(error => { part("message").textContent = String(error); });
