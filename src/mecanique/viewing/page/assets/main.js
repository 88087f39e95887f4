// Opens the parcel, builds the picture and runs it: one loop, one clock.

import { bytesOf, gunzip, layoutOf, openParcel, Table } from "./unpack.js";
import { Stage } from "./stage.js";
import { Camera } from "./camera.js";
import { Arrows } from "./arrows.js";
import { JointMarks, Lines, Traces } from "./lines.js";
import { Labels } from "./labels.js";
import { listenToKeys, Player, Transport } from "./player.js";
import { Plots, quantities } from "./plots.js";
import { wireTabs, save } from "./tabs.js";
import { ForceTable, LedgerTable } from "./tables.js";
import { Companion, startBox, travelsFar } from "./companion.js";
import { findPlace, History, LiveClock, wireNotes, wireSliders } from "./live.js";
import {
  wireCameras,
  wireForces,
  wireFreeBody,
  wirePrint,
  wireShow,
  wireTooltip,
} from "./controls.js";

// How much of a path a stream leaves behind [frames]: longer ones are no longer read, and slow to draw.
const RECENT = 1500;

async function loadViewer() {
  const script = document.createElement("script");
  script.textContent = new TextDecoder().decode(await gunzip(bytesOf("viewer")));
  document.head.append(script);
}

function sampleRows(table, bodies, width, most) {
  const count = Math.min(table.n, most);
  return Array.from({ length: count }, (_, i) => {
    const t = table.first + ((table.last - table.first) * i) / Math.max(count - 1, 1);
    return table.row(t, bodies, new Float64Array(width));
  });
}

function boxFrom(three, [low, high]) {
  return new three.Box3(new three.Vector3(...low), new three.Vector3(...high));
}

async function start() {
  wireTabs(document.querySelector("[role=tablist]"));
  const { header: scene, parts } = openParcel(await gunzip(bytesOf("parcel")));
  await loadViewer();
  const layout = layoutOf(scene);
  const table = new Table(scene.table, parts[0]);
  const live = scene.live ? new LiveClock(scene.live, layout.end) : null;
  const recorded = !live;
  const clock = live ?? new Player(table);
  const row = table.row(table.first, scene.bodies.length, new Float64Array(layout.end));

  const stage = new Stage(document.getElementById("pane"), parts.slice(1), scene);
  const few = sampleRows(table, scene.bodies.length, layout.end, 240);
  const rides = (live && !recorded) || (!scene.bounds && travelsFar(stage, few, layout));
  const around = rides ? startBox(stage, few, layout) : stage.bounds(few, layout);
  const box = scene.bounds ? boxFrom(stage.three, scene.bounds) : around;
  stage.furnish(box, scene.planar, scene.ground);
  const arrows = new Arrows(stage, scene, layout);
  arrows.survey(table);
  const lines = new Lines(stage, scene, layout, row);
  const traces = new Traces(stage, scene, layout, recorded ? table.n : RECENT);
  const marks = new JointMarks(stage, scene);
  const labels = new Labels(stage, document.getElementById("labels"), scene, arrows);
  const camera = new Camera(stage, box);
  const transport = new Transport(clock);
  const data = recorded ? table : live.history;
  const plots = new Plots(
    document.getElementById("charts"),
    data,
    clock,
    quantities(scene, layout),
    scene.fileName,
  );
  plots.peaks.set("m", stage.size);
  const ledger = new LedgerTable(scene, layout);
  const forces = new ForceTable(scene, layout);

  let stale = true;
  const redraw = () => (stale = true);
  const keys = wireCameras(camera, scene);
  const fewBodies = scene.bodies.length <= 8;
  wireShow([
    [
      "Grid",
      true,
      (on) => {
        stage.grid.visible = on;
        redraw();
      },
    ],
    [
      "Ground",
      !scene.planar || scene.ground !== null,
      (on) => {
        stage.ground.visible = on;
        redraw();
      },
    ],
    [
      "Axes",
      true,
      (on) => {
        labels.compass.hidden = !on;
        redraw();
      },
    ],
    [
      "Body names",
      fewBodies && scene.bodies.length > 1,
      (on) => {
        labels.shown.bodies = on;
        redraw();
      },
    ],
    [
      "Joints",
      true,
      (on) => {
        marks.show(on);
        redraw();
      },
    ],
    [
      "Joint names",
      false,
      (on) => {
        labels.shown.joints = on;
        redraw();
      },
    ],
    [
      "Traces",
      true,
      (on) => {
        traces.shown = on;
        redraw();
      },
    ],
    [
      "Values at the arrows",
      false,
      (on) => {
        labels.shown.values = on;
        redraw();
      },
    ],
  ]);
  wireForces(arrows, scene, redraw);
  const choose = (body) => {
    arrows.body = body;
    forces.choose(body);
    stage.nodes.forEach((node, b) => (node.visible = body === null || b === body));
    lines.items.forEach((item) => (item.group.userData.away = body !== null));
    redraw();
  };
  wireFreeBody(scene, choose);
  choose(null);
  wireTooltip(stage, arrows);
  wirePrint(stage, plots, clock);
  listenToKeys(transport, keys);
  const urdf = document.getElementById("save-urdf");
  if (urdf)
    urdf.onclick = () =>
      save(
        `${scene.fileName}.urdf`,
        document.getElementById("urdf-text").textContent,
        "application/xml",
      );

  const companion = rides ? new Companion(stage, camera, box, row) : null;
  companion?.wire(document.getElementById("follow"));
  if (live) wireLive(live, stage, transport, traces, companion, redraw);
  if (recorded && scene.traces.length)
    for (let k = 0; k < table.n; k++)
      traces.add(table.row(table.time(k), scene.bodies.length, new Float64Array(layout.end)));

  const show = () => {
    stage.pose(row);
    arrows.pose(row);
    lines.pose(row);
    for (const { group } of lines.items) group.visible &&= !group.userData.away;
    traces.reveal(!recorded ? Infinity : Math.floor(table.index(clock.time) + 1e-6) + 1);
    camera.move(row);
    ledger.show(row);
    forces.show(row);
  };
  let shown = null;
  let drawn = 0;
  let behind = false;
  let last = 0;
  const frame = (now) => {
    requestAnimationFrame(frame);
    const came = clock.tick(now);
    if (live ? came : clock.time !== shown) {
      if (live) {
        row.set(live.row);
        arrows.learn(row);
        if (!recorded) {
          if (clock.time < shown) {
            traces.clear();
            companion?.reset();
          }
          traces.add(row);
        }
      } else table.row(clock.time, scene.bodies.length, row);
      shown = clock.time;
      stale = true;
    }
    if (shown !== null && companion?.step(row, (now - last) / 1000)) stale = true;
    last = now;
    if (stale) show();
    stale = false;
    transport.show();
    behind ||= came;
    if (!recorded && behind && now - drawn > 120) {
      drawn = now;
      behind = false;
      plots.draw();
    } else if (recorded) plots.follow();
    const moved = stage.viewer.needs_render;
    stage.render();
    if (moved) labels.pose(row);
  };
  stage.resize();
  camera.look(scene.planar ? "front" : "free");
  if (live) findPlace();
  plots.draw();
  window.mecanique = {
    scene,
    table,
    layout,
    clock,
    row,
    stage,
    arrows,
    lines,
    traces,
    labels,
    camera,
    companion,
    plots,
  };
  document.body.classList.add("ready");
  if (!live && !matchMedia("(prefers-reduced-motion: reduce)").matches) clock.play();
  requestAnimationFrame(frame);
}

function wireLive(live, stage, transport, traces, companion, redraw) {
  const notice = document.getElementById("notice");
  live.onlink = (on) => {
    notice.textContent = on ? "" : "The connection is lost; waiting for the program to come back.";
    notice.hidden = on;
  };
  live.onstate = (state) => {
    transport.refit();
    transport.digits = Math.max(2, 2 - Math.floor(Math.log10(state.speed)));
    if (state.restart) {
      live.history.clear();
      traces.clear();
      companion?.reset();
    }
    const speed = document.getElementById("speed");
    if (![...speed.options].some((option) => Number(option.value) === state.speed))
      speed.append(new Option(`${state.speed}×`, state.speed));
    speed.value = String(state.speed);
    redraw();
  };
  live.oncommand = (command) => stage.viewer.handle_command_bytearray(command);
  document.getElementById("loop-label").hidden = true;
  wireNotes(live);
  wireSliders(live);
}

start().catch((error) => {
  const notice = document.getElementById("notice");
  notice.hidden = false;
  notice.textContent = `This page could not be shown: ${error.message}`;
  throw error;
});
