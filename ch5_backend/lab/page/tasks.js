"use strict";
// The tasks beside the pictures: a prediction first, then a try, and what C++ says to it.

// What has been predicted and solved stays in the browser, where it may: {guesses: {id: option}, solved: [id, …], keys: whether single keys work}.
const KEPT = "ch5-lab-tasks";
const kept = {guesses: {}, solved: [], keys: true};
try {
  Object.assign(kept, JSON.parse(localStorage.getItem(KEPT)) || {});
} catch { /* then only for now */ }
function keep() {
  try {
    localStorage.setItem(KEPT, JSON.stringify(kept));
  } catch { /* likewise */ }
}

const taskNow = () => CHALLENGES.find(one => one.id === state.task && one.panel === state.panel);
const asker = task => values => answerTo(task.panel, {...task.start, ...values});
const isVeiled = () => Boolean(taskNow()) && kept.guesses[state.task] === undefined;

function openTask(id) {
  const task = CHALLENGES.find(one => one.id === id);
  state.task = id;
  if (task) {
    Object.assign(state, {panel: task.panel, values: {...firstValues(task.panel), ...task.start}, beside: null});
  }
  writeAddress();
  build();
  if (task) part("task").focus();
}

const optionText = (task, option) => TEXT[`task.${task.id}.${option}`] ? text(`task.${task.id}.${option}`) : asPowers(option);

function drawTasks() {
  const task = taskNow();
  part("task-count").textContent = say("tasks.count", {solved: kept.solved.length, all: CHALLENGES.length});
  part("task-list").replaceChildren(...CHALLENGES.map((one, i) => {
    const done = kept.solved.includes(one.id), title = text(`task.${one.id}`);
    return element("button", {type: "button", id: `task-${one.id}`, title, "aria-pressed": String(one === task),
      "aria-label": `${i + 1}. ${title}${done ? `, ${text("task.done")}` : ""}`,
      click: () => openTask(one === task ? "" : one.id)}, `${i + 1}${done ? " ✓" : ""}`);
  }));
  part("task").hidden = !task;
  if (!task) return;
  const guess = kept.guesses[task.id], next = CHALLENGES[(CHALLENGES.indexOf(task) + 1) % CHALLENGES.length];
  const options = task.options.map((option, i) => element("button", {type: "button", id: `option-${i}`,
    "aria-pressed": String(i === guess), disabled: guess !== undefined && i !== guess, click: () => predict(task, i)},
  optionText(task, option)));
  part("task").classList.toggle("guessed", guess !== undefined);
  part("task-goal").replaceChildren(
    element("h2", {}, `${CHALLENGES.indexOf(task) + 1}. ${text(`task.${task.id}`)}`),
    element("p", {class: "asked"}, ...rich(`task.${task.id}.predict`)),
    element("div", {class: "row asked", role: "group", "aria-label": text("task.predict")}, ...options),
    element("p", {id: "predicted", role: "status"}),
    guess === undefined ? "" : element("p", {id: "task-do"}, ...rich(`task.${task.id}.do`)));
  part("task-end").replaceChildren(
    element("p", {id: "verdict", role: "status"}),
    element("progress", {id: "task-way", max: 1, value: 0, hidden: guess === undefined, "aria-label": text("task.way")}),
    element("div", {class: "row"},
      element("button", {type: "button", id: "task-again", click: () => forget(task)}, text("task.again")),
      element("button", {type: "button", id: "task-next", click: () => openTask(next.id)}, text("task.next")),
      element("button", {type: "button", id: "task-leave", click: () => openTask("")}, text("task.leave"))));
  if (guess !== undefined) tellPrediction(task, guess);
}

function predict(task, guess) {
  if (kept.guesses[task.id] !== undefined) return;
  kept.guesses[task.id] = guess;
  keep();
  build();
  (part(`option-${guess}`).checkVisibility() ? part(`option-${guess}`) : part("task")).focus();
}

function forget(task) {
  delete kept.guesses[task.id];
  kept.solved = kept.solved.filter(id => id !== task.id);
  keep();
  openTask(task.id);
}

async function tellPrediction(task, guess) {
  const right = await task.right(asker(task));
  if (taskNow() !== task || !part("predicted")) return;
  part("predicted").className = right === guess ? "good" : "bad";
  part("predicted").textContent = right === guess ? text("task.right")
    : say("task.wrong", {right: optionText(task, task.options[right])});
}

// After each picture.
async function judge(answer, values) {
  const task = taskNow();
  if (!task || isVeiled()) return;
  const number = await task.number(answer, asker(task), values);
  const solved = await task.solved(answer, values, asker(task), number);
  if (taskNow() !== task || values !== state.values || !part("verdict")) return;
  const isNew = solved && !kept.solved.includes(task.id);
  if (isNew) {
    kept.solved.push(task.id);
    keep();
    drawTasks();
  }
  const isDone = kept.solved.includes(task.id);
  part("verdict").className = isDone ? "good" : "soft";
  const [now, goal, way = Math.min(now / goal, goal / now)] = number;
  part("task-way").value = isDone ? 1 : way || 0;
  part("verdict").replaceChildren(...(isDone ? [text("task.solved"), " ", ...rich(`task.${task.id}.why`)]
    : [text("task.open"), " ", say("task.number", {name: text(`task.${task.id}.number`), now: short(now), goal: short(goal)})]));
}
