// Numbers at the present instant: ledgers of virtual work and of energy, all forces on one body.

import { colorOf } from "../picture/arrows.js";
import { balance, totalWork } from "./balance.js";
import { measure } from "../data/numbers.js";
import { isNothing } from "../data/scales.js";
import { make, swatch } from "./elements.js";

function cell(row, text = "", className = "") {
  const made = row.insertCell();
  made.textContent = text;
  made.className = className;
  return made;
}

// A table's data cells before those with numbers: what the force is called, and its displacement.
const HEADS = 2;

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
    const work = row.subarray(this.first, this.first + this.rows.length * this.count);
    this.rows.forEach((line, r) => {
      for (let c = 0; c < this.count; c++)
        line.cells[c + HEADS].textContent = measure(work[r * this.count + c]);
    });
    totalWork(work, this.count).forEach((text, c) => (this.sums[c].textContent = text));
  }
}

// Energies now, with what friction and impacts took, beside what there was and what came.
export class EnergyTable {
  constructor(scene, layout, table) {
    const column = (name) => layout.series + scene.series.findIndex((each) => each.name === name);
    const cells = [...document.querySelectorAll("#energy-table [data-series]")];
    this.rows = cells.map((place) => ({ place, column: column(place.dataset.series) }));
    this.sums = document.querySelectorAll("#energy-table tfoot td");
    this.work = column("energy work");
    this.lost = this.rows.slice(2); // after kinetic and potential energy
    this.total = column("energy total");
    this.take(table);
  }

  // Goes over to another motion.
  take(table) {
    this.start = this.rows.length ? table.value(0, this.total) : 0;
  }

  show(row) {
    if (!this.rows.length) return;
    const sum = (rows) => rows.reduce((total, { column }) => total + row[column], 0);
    for (const { place, column } of this.rows) place.textContent = measure(row[column]);
    this.sums[0].textContent = measure(sum(this.rows));
    // the work of all that has no potential includes what friction and impacts take
    this.sums[1].textContent = measure(this.start + row[this.work] + sum(this.lost));
  }
}

export class ForceTable {
  constructor(scene, layout) {
    this.arrows = scene.arrows.map((arrow, i) => ({ ...arrow, column: layout.arrows + 6 * i }));
    // what is nothing beside the largest force so far is rounding
    this.largest = {};
    this.table = document.getElementById("force-table");
    this.sum = document.getElementById("force-sum");
  }

  // List the forces on one body, or every force when none is chosen.
  choose(body) {
    this.body = body;
    const members = this.arrows.filter((arrow) => body === null || arrow.body === body);
    this.forces = members.filter((arrow) => body === null || arrow.kind !== "inertia");
    this.inertia = members.filter((arrow) => arrow.kind === "inertia");
    const rows = this.table.tBodies[0];
    rows.replaceChildren();
    for (const arrow of this.forces) this.list(arrow, rows);
    this.table.hidden = !this.forces.length;
    document.getElementById("no-forces").hidden = this.forces.length > 0;
  }

  list(arrow, rows) {
    const row = rows.insertRow();
    // the name says what it acts on
    cell(row).append(swatch(colorOf(arrow.kind)), make("span", { dir: "auto" }, arrow.name));
    for (let i = 0; i < 4; i++) cell(row, "", "number");
    cell(row, arrow.unit);
  }

  show(row) {
    const rows = this.table.tBodies[0].rows;
    const read = ({ unit, column }) => ({
      unit,
      at: [...row.subarray(column, column + 3)],
      vector: [...row.subarray(column + 3, column + 6)],
    });
    const loads = this.forces.map(read);
    for (const { unit, vector } of loads)
      this.largest[unit] = Math.max(this.largest[unit] ?? 0, Math.hypot(...vector));
    loads.forEach(({ unit, vector }, i) => {
      [...vector, Math.hypot(...vector)].forEach((x, c) => {
        rows[i].cells[c + 1].textContent = isNothing(x, this.largest[unit]) ? "0" : measure(x, 4);
      });
    });
    const alone = this.body !== null && loads.length;
    const lines = alone ? balance(loads, this.inertia.map(read)) : [];
    this.sum.replaceChildren(...lines.flatMap(([what, value]) => describe(what, value)));
  }
}

const describe = (what, value) => [make("dt", {}, what), make("dd", {}, value)];

// Sets tables in less room where they are wider than their frame; what is hidden follows when shown.
export function wireTables(panel) {
  const rooms = new WeakMap();
  const fit = (table) => {
    const room = table.parentElement.clientWidth;
    if (!room) return;
    if (rooms.get(table) !== room) table.classList.remove("tight");
    rooms.set(table, room);
    if (table.offsetWidth > room) table.classList.add("tight");
  };
  const sizes = new ResizeObserver((entries) =>
    requestAnimationFrame(() => entries.forEach(({ target }) => fit(target))),
  );
  for (const table of panel.querySelectorAll("table")) sizes.observe(table);
}
