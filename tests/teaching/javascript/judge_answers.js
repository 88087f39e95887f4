// Judges answers as a page does: reads {question, answers} from standard input, writes verdicts.

import { readFileSync } from "node:fs";
import { judge } from "../../../src/mecanique/teaching/assets/judge.js";

const { question, answers } = JSON.parse(readFileSync(0, "utf8"));
process.stdout.write(JSON.stringify(answers.map((answer) => judge(question, answer))));
