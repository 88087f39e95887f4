// What the pane shows: bodies, arrows, lines, traces and labels, and the camera that frames them.

import { Arrows } from "./arrows.js";
import { Camera } from "./camera.js";
import { Companion } from "./companion.js";
import { exaggerate } from "./exaggeration.js";
import { frame } from "../sketch/framing.js";
import { SAMPLES } from "../sketch/sketch.js";
import { Ghost } from "./ghost.js";
import { Labels } from "./labels.js";
import { JointMarks, Lines, Traces } from "./lines.js";
import { Stage } from "./stage.js";

// How many points of a stream's path are kept: a longer one is slow to draw and hard to read.
const RECENT = 1500;
// How many points there is room for where the length of the motion can be changed.
const MOST_POINTS = 7200;
const FEWER = 120; // instants looked at while a slider is moved

export class Picture {
  constructor(scene, layout, table, parts, streamed) {
    this.scene = scene;
    this.row = table.row(table.first, scene.bodies.length, new Float64Array(layout.end));
    this.stage = new Stage(document.getElementById("pane"), parts, scene);
    const { box, far } = this.frame(table, layout, streamed);
    this.stage.furnish(box, scene.planar, scene.ground);
    this.arrows = new Arrows(this.stage, scene, layout);
    this.arrows.survey(table);
    this.lines = new Lines(this.stage, scene, layout, this.row);
    const points = scene.engine ? MOST_POINTS : table.n;
    this.traces = new Traces(this.stage, scene, layout, streamed ? RECENT : points);
    this.marks = new JointMarks(this.stage, scene);
    this.labels = new Labels(this.stage, document.getElementById("labels"), scene, this.arrows);
    this.camera = new Camera(this.stage, box);
    this.companion = far ? new Companion(this.stage, this.camera, box, this.row) : null;
    this.ghost = new Ghost(this.stage, layout.end);
    Object.assign(this, { layout, factor: 1, rest: null, drawn: this.row.slice() });
    this.stale = true;
  }

  // The box to frame, and whether the camera must keep up with a motion that leaves any such box.
  frame(table, layout, streamed, samples = SAMPLES) {
    const { stage, scene } = this;
    const rows = table.sample(samples, scene.bodies.length, layout.series);
    const { bounds, joints } = scene;
    const found = frame(stage.extents, rows, layout, { bounds, joints, streamed });
    return { box: stage.boxFrom(found.box), far: found.far };
  }

  // Draw the picture anew, even if time stands still.
  redraw() {
    this.stale = true;
  }

  // Show one body alone with the forces on it, or all bodies if it is null.
  isolate(body) {
    this.arrows.body = body;
    this.stage.nodes.forEach((node, b) => (node.visible = body === null || b === body));
    this.lines.shown = body === null;
    this.redraw();
  }

  // Frame another motion, unless it stays in the picture and fills a good part of it.
  refit(table, layout) {
    const { camera, stage } = this;
    const { box, far } = this.frame(table, layout, false, FEWER);
    if (far || this.companion) return;
    const size = (each) => each.getSize(new stage.three.Vector3()).length();
    if (
      camera.box
        .clone()
        .expandByScalar(0.02 * stage.size)
        .containsBox(box)
    )
      if (size(box) > 0.6 * size(camera.box)) return;
    camera.box = box;
    if (camera.preset) camera.look(camera.preset);
  }

  // Forget the path behind: the motion starts again.
  restart() {
    this.traces.clear();
    this.companion?.reset();
  }

  // Let the camera keep up with what moves.
  keepUp(seconds) {
    if (this.companion?.step(this.row, seconds)) this.redraw();
  }

  // Put everything where the row says, with so many points of the traces.
  pose(reached) {
    const { factor, rest, layout, drawn } = this;
    const row = factor === 1 ? this.row : exaggerate(this.row, rest, factor, layout, drawn);
    this.stage.pose(row);
    this.arrows.pose(row);
    this.lines.pose(row);
    this.ghost.pose();
    this.traces.reveal(reached);
    this.camera.move(row);
    this.stale = false;
  }

  render() {
    const moved = this.stage.viewer.needs_render;
    this.stage.render();
    if (moved) this.labels.pose(this.stage.row ?? this.row);
  }
}
