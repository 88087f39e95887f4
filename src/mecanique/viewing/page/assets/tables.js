// Numbers at the present instant: the ledger of virtual work, and all forces on one body with their sum.

import { colorOf } from "./arrows.js";
import { measure } from "./numbers.js";

function cell(row, text = "", className = "") {
  const made = row.insertCell();
  made.textContent = text;
  made.className = className;
  return made;
}

export class LedgerTable {
  constructor(scene, layout) {
    this.first = layout.ledger;
    this.body = document.querySelector("#ledger tbody");
    this.count = scene.ledger.coordinates.length;
    this.rows = this.body ? [...this.body.rows] : [];
    this.sums = [...document.querySelectorAll("#ledger tfoot td")];
  }

  show(row) {
    if (!this.rows.length) return;
    const sums = new Array(this.count).fill(0);
    const sizes = new Array(this.count).fill(0);
    this.rows.forEach((line, r) => {
      for (let c = 0; c < this.count; c++) {
        const x = row[this.first + r * this.count + c];
        sums[c] += x;
        sizes[c] += Math.abs(x);
        line.cells[c + 2].textContent = measure(x);
      }
    });
    // what rounding of the key frames leaves is called zero
    sums.forEach(
      (sum, c) => (this.sums[c].textContent = Math.abs(sum) < 2e-5 * sizes[c] ? "0" : measure(sum)),
    );
  }
}

const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
const add = (a, b) => a.map((x, i) => x + b[i]);
const less = (a, b) => a.map((x, i) => x - b[i]);

export class ForceTable {
  constructor(scene, layout) {
    this.scene = scene;
    this.layout = layout;
    this.table = document.getElementById("force-table");
    this.sum = document.getElementById("force-sum");
    this.key = "";
  }

  // Forces on one body, or every force when none is chosen; rebuilt only when the choice changes.
  choose(body) {
    this.body = body;
    this.members = this.scene.arrows
      .map((arrow, i) => ({ ...arrow, column: this.layout.arrows + 6 * i }))
      .filter((arrow) => body === null || arrow.body === body);
    this.forces = this.members.filter((arrow) => body === null || arrow.kind !== "inertia");
    this.inertia = this.members.filter((arrow) => arrow.kind === "inertia");
    const rows = this.table.tBodies[0];
    rows.replaceChildren();
    for (const arrow of this.forces) {
      const row = rows.insertRow();
      const name = cell(row);
      const swatch = document.createElement("i");
      swatch.style.backgroundColor = colorOf(arrow.kind);
      const text = document.createElement("span");
      text.dir = "auto";
      text.textContent = arrow.name; // which says what it acts on
      name.append(swatch, text);
      for (let i = 0; i < 4; i++) cell(row, "", "number");
      cell(row, arrow.unit);
    }
    this.table.hidden = !this.forces.length;
    document.getElementById("no-forces").hidden = this.forces.length > 0;
  }

  show(row) {
    const rows = this.table.tBodies[0].rows;
    this.forces.forEach((arrow, i) => {
      const vector = [...row.subarray(arrow.column + 3, arrow.column + 6)];
      [...vector, Math.hypot(...vector)].forEach(
        (x, c) => (rows[i].cells[c + 1].textContent = measure(x, 4)),
      );
    });
    if (this.body === null || !this.forces.length) this.sum.replaceChildren();
    else this.sum.replaceChildren(...this.balance(row));
  }

  // Σ F against m a, and Σ M about the center of mass against the change of angular momentum.
  balance(row) {
    const parts = (arrow) => ({
      at: [...row.subarray(arrow.column, arrow.column + 3)],
      vector: [...row.subarray(arrow.column + 3, arrow.column + 6)],
    });
    const center = this.inertia.find((arrow) => arrow.unit === "N");
    let force = [0, 0, 0];
    let moment = [0, 0, 0];
    let [sizeF, sizeM] = [0, 0];
    const about = center ? parts(center).at : [0, 0, 0];
    for (const arrow of this.forces) {
      const { at, vector } = parts(arrow);
      if (arrow.unit === "N") {
        force = add(force, vector);
        sizeF += Math.hypot(...vector);
        const arm = less(at, about);
        moment = add(moment, cross(arm, vector));
        // what rounding of the key frames may leave grows with arm and force, also where they are parallel
        sizeM += Math.hypot(...arm) * Math.hypot(...vector);
      } else {
        moment = add(moment, vector);
        sizeM += Math.hypot(...vector);
      }
    }
    const written = (v, size) =>
      `(${v.map((x) => (Math.abs(x) < 1e-4 * size ? "0" : measure(x))).join(", ")})`;
    const lines = [["Σ F", written(force, sizeF), "N"]];
    if (center) {
      const rate = parts(center).vector.map((x) => -x);
      lines.push(["m a", written(rate, Math.max(sizeF, Math.hypot(...rate))), "N"]);
      lines.push(["Σ M about the center of mass", written(moment, sizeM), "N·m"]);
    }
    const spin = this.inertia.find((arrow) => arrow.unit !== "N");
    if (spin) {
      const rate = parts(spin).vector.map((x) => -x);
      lines.push(["I α + ω × I ω", written(rate, Math.max(sizeM, Math.hypot(...rate))), "N·m"]);
    }
    return lines.flatMap(([what, value, unit]) => {
      const [term, meaning] = [document.createElement("dt"), document.createElement("dd")];
      term.textContent = what;
      meaning.textContent = `${value} ${unit}`;
      return [term, meaning];
    });
  }
}
