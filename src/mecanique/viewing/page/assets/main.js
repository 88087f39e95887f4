// Opens the parcel, builds the picture and what steers it, and starts the loop.

import { Bench } from "./engine/bench.js";
import { Machine } from "./engine/machine.js";
import { Motion } from "./clock/motion.js";
import { wireLive } from "./clock/connection.js";
import {
  wireCameras,
  wireForces,
  wireFreeBody,
  wirePrint,
  wireShow,
  wireTooltip,
} from "./panels/controls.js";
import { LiveClock } from "./clock/live.js";
import { Loop } from "./clock/loop.js";
import { Hand } from "./picture/hand.js";
import { Picture } from "./picture/picture.js";
import { wireBreaking } from "./equations/breaking.js";
import { wireCopies, wireSplitter } from "./equations/copies.js";
import { findPlace, wireEmbedding } from "./panels/place.js";
import { listenToKeys, Player, Transport } from "./clock/player.js";
import { Plots, quantities } from "./panels/plots.js";
import { Recording, Stream } from "./clock/sources.js";
import { Setup } from "./panels/setup.js";
import { ForceTable, LedgerTable } from "./panels/tables.js";
import { wireSave, wireTabs } from "./panels/tabs.js";
import { bytesOf, gunzip, layoutOf, openParcel, Table } from "./data/unpack.js";

async function loadViewer() {
  const script = document.createElement("script");
  script.textContent = new TextDecoder().decode(await gunzip(bytesOf("viewer")));
  document.head.append(script);
}

// The program stands in the page like the viewer; its hash in the page's policy admits it.
async function loadSetup(scene, layout, motion) {
  if (!scene.engine) return null;
  const script = document.createElement("script");
  script.textContent = new TextDecoder().decode(await gunzip(bytesOf("program")));
  document.head.append(script);
  const machine = new Machine(scene.engine, globalThis.mecaniqueProgram);
  return new Setup(new Bench(machine, scene, layout), motion);
}

function wirePicture(picture, forces, transport) {
  const keys = wireCameras(picture.camera, picture.scene);
  wireShow(picture);
  wireForces(picture);
  wireFreeBody(picture, forces);
  wireTooltip(picture.stage, picture.arrows);
  listenToKeys(transport, keys);
  picture.companion?.wire(document.getElementById("follow"));
}

async function start() {
  wireEmbedding();
  wireTabs(document.querySelector("[role=tablist]"));
  const { header: scene, parts } = openParcel(await gunzip(bytesOf("parcel")));
  await loadViewer();
  const layout = layoutOf(scene);
  const table = new Table(scene.table, parts[0]);
  const live = scene.live ? new LiveClock(scene.live, layout.end) : null;
  const clock = live ?? new Player(table);
  const picture = new Picture(scene, layout, table, parts.slice(1), live !== null);
  const transport = new Transport(clock);
  const plots = new Plots(live?.history ?? table, clock, quantities(scene, layout), scene.fileName);
  plots.peaks.set("m", picture.stage.size);
  const forces = new ForceTable(scene, layout);
  const tables = [new LedgerTable(scene, layout), forces];

  wirePicture(picture, forces, transport);
  wirePrint(picture.stage, plots, clock);
  wireSave(scene.fileName);
  wireCopies(document.getElementById("panel"));
  const equations = document.getElementById("panel-equations");
  if (equations) wireBreaking(equations);
  wireSplitter(document.getElementById("splitter"));

  const source = live
    ? new Stream(live, picture, plots)
    : new Recording(table, clock, picture, plots);
  const motion = { source, picture, layout, plots, clock, transport, tables };
  const setup = await loadSetup(scene, layout, new Motion(motion));
  picture.stage.resize();
  picture.camera.look(scene.planar ? "front" : "free");
  if (live) {
    wireLive(live, picture, transport);
    findPlace();
  }
  plots.draw();
  setup?.open(location.hash);
  if (setup) new Hand(picture, clock, setup);
  window.mecanique = { ...picture, picture, layout, table, clock, plots, setup };
  document.body.classList.add("ready");
  if (!live && !matchMedia("(prefers-reduced-motion: reduce)").matches) clock.play();
  new Loop(source, picture, tables, transport).start();
}

start().catch((error) => {
  const notice = document.getElementById("notice");
  notice.hidden = false;
  notice.textContent = `This page could not be shown: ${error.message}`;
  throw error;
});
