"use strict";
// In a thread of its own, behind the solver's program: a query comes in, C++'s answer goes out.
CourseLab().then(lab => {
  onmessage = ({data}) => postMessage(lab.ccall("LabAnswer", "string", ["string"], [data]));
  postMessage("");  // ready
});
