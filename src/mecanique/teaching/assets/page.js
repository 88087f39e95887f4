// Joins the judge to the page and, where there is one, to the SCORM 1.2 runtime around it.

import { judge } from "./judge.js";

const WORDS = {
  right: "Right.",
  "right except for form": "Right except for form",
  incomplete: "Right as far as it goes, but incomplete",
  wrong: "Wrong",
  teacher: "This page cannot judge it",
};
const MOST_KEPT = 4000; // characters that SCORM 1.2 keeps of a state

const field = (id) => document.getElementById(id);
const question = JSON.parse(field("question").textContent);
const runtime = findRuntime(window);
const started = Date.now();

/** SCORM's runtime is an object API of a frame around this one, or of the window that opened it. */
function findRuntime(start) {
  for (let frame = start, k = 0; frame && k < 10; k += 1) {
    try {
      if (frame.API) return frame.API;
    } catch {
      return null; // a page of another origin
    }
    frame = frame === frame.parent ? frame.opener : frame.parent;
  }
  return null;
}

function score(verdict) {
  if (verdict.outcome === "right") return 1;
  if (verdict.outcome === "right except for form") return question.form;
  const worth = { right: 1, "right except for form": question.form };
  const credit = verdict.lines.reduce((sum, line) => sum + (worth[line] ?? 0), 0);
  const { independent = 0, needed = 1 } = verdict;
  return Math.min(credit, independent) / Math.max(needed, verdict.lines.length);
}

function show(verdict) {
  const said = [WORDS[verdict.outcome]];
  if (verdict.lines.length > 1)
    verdict.lines.forEach((line, k) => said.push(`Equation ${k + 1}: ${line}`));
  said.push(...verdict.forms, ...verdict.causes.map((cause) => `A likely cause: ${cause}.`));
  if (verdict.outcome === "teacher")
    said.push("Save it, and hand it in: the teacher's judge reads more.");
  field("verdict").textContent = said.join("\n");
  field("verdict").className =
    verdict.outcome === "right" ? "right" : verdict.outcome.split(" ")[0];
}

function report(verdict, answer) {
  if (!runtime) return;
  const points = Math.round(100 * score(verdict));
  const judged = verdict.outcome !== "teacher";
  const passed = points === 100 ? "passed" : "failed";
  runtime.LMSSetValue("cmi.suspend_data", answer.slice(0, MOST_KEPT));
  if (judged) runtime.LMSSetValue("cmi.core.score.raw", String(points));
  runtime.LMSSetValue("cmi.core.lesson_status", judged ? passed : "incomplete");
  runtime.LMSCommit("");
}

function spent() {
  const seconds = Math.round((Date.now() - started) / 1000);
  const parts = [Math.floor(seconds / 3600), Math.floor(seconds / 60) % 60, seconds % 60];
  return parts.map((part) => String(part).padStart(2, "0")).join(":");
}

/** A table that `mecanique grade` reads. */
function save() {
  const link = document.createElement("a");
  const text = JSON.stringify({ [question.id]: field("answer").value }, null, 2);
  link.href = URL.createObjectURL(new Blob([text], { type: "application/json" }));
  link.download = "answers.json";
  link.click();
  URL.revokeObjectURL(link.href);
}

document.querySelector("form").addEventListener("submit", (event) => {
  event.preventDefault();
  const answer = field("answer").value;
  const verdict = judge(question, answer);
  show(verdict);
  report(verdict, answer);
});
field("save").addEventListener("click", save);
if (runtime) {
  runtime.LMSInitialize("");
  runtime.LMSSetValue("cmi.core.score.min", "0");
  runtime.LMSSetValue("cmi.core.score.max", "100");
  field("answer").value = runtime.LMSGetValue("cmi.suspend_data");
  addEventListener("pagehide", () => {
    runtime.LMSSetValue("cmi.core.session_time", spent());
    runtime.LMSFinish("");
  });
}
