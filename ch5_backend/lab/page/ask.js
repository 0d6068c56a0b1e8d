"use strict";
// Questions to C++, which computes in a worker, so that the page never waits for it.

const jobs = [];  // {words, isWanted, done}
let solver = null, present = null;

function startSolver() {
  const program = new Blob([part("program").textContent, "\n", part("worker").textContent], {type: "text/javascript"});
  return new Promise((done, fail) => {
    const worker = new Worker(URL.createObjectURL(program));
    worker.onerror = event => fail(new Error(event.message));
    worker.onmessage = () => {
      solver = worker;
      worker.onmessage = ({data}) => {
        const {done: tell} = present;
        present = null;
        tell(data);
        pump();
      };
      pump();
      done();
    };
  });
}

// The answer's text, or null if it was not wanted any more when its turn came. What is `urgent` goes first.
function ask(words, {isWanted = () => true, urgent = false} = {}) {
  return new Promise(done => {
    jobs[urgent ? "unshift" : "push"]({words, isWanted, done});
    pump();
  });
}

function pump() {
  while (solver && !present && jobs.length) {
    const job = jobs.shift();
    if (job.isWanted()) {
      present = job;
      solver.postMessage(job.words);
    } else {
      job.done(null);
    }
  }
}

// What a check asks in addition: the answer to other settings of a panel.
const known = new Map();
async function answerTo(panel, values) {
  const words = query(panel, {...firstValues(panel), ...values});
  if (!known.has(words)) known.set(words, JSON.parse(await ask(words)));
  return known.get(words);
}
