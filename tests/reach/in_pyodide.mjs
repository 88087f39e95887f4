// Unpacks an archive in Pyodide and runs a program there: node in_pyodide.mjs ARCHIVE PROGRAM
import { readFileSync } from "node:fs";
import { argv, exit, stderr } from "node:process";
import { loadPyodide } from "pyodide";

const [archive, program] = argv.slice(2);
const python = await loadPyodide();
python.unpackArchive(new Uint8Array(readFileSync(archive)), "zip");
try {
  python.runPython(readFileSync(program, "utf8"));
} catch (error) {
  stderr.write(`${error.message}\n`); // without the loader's own text, which is one long line
  exit(1);
}
