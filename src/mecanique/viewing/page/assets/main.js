// Opens the parcel, shows a sketch that moves, builds the picture and what steers it, and starts the
// loop.

import { Bench, readFragment } from "./engine/bench.js";
import { Machine } from "./engine/machine.js";
import { Motion } from "./clock/motion.js";
import { wireComputing, wireLive } from "./clock/connection.js";
import {
  wireCameras,
  wireForces,
  wireMenus,
  listForces,
  wireFreeBody,
  wirePrint,
  wireShow,
  wireTooltip,
} from "./panels/controls.js";
import { make } from "./panels/elements.js";
import { LiveClock } from "./clock/live.js";
import { ModeStrips } from "./clock/strips.js";
import { Loop } from "./clock/loop.js";
import { Hand } from "./picture/hand.js";
import { Anatomy } from "./inspection/anatomy.js";
import { Beside, quantitiesBeside } from "./studies/beside.js";
import { EnergyBars } from "./studies/bars.js";
import { Exaggerating } from "./studies/exaggerating.js";
import { Modes } from "./studies/modes.js";
import { Picture } from "./picture/picture.js";
import { wireBreaking } from "./equations/breaking.js";
import { wireCopies, wireSplitter } from "./equations/copies.js";
import { findPlace, wireEmbedding } from "./panels/place.js";
import { listenToKeys, Player, Transport } from "./clock/player.js";
import { Plots, quantities } from "./panels/plots.js";
import { Posture, wireFindings } from "./inspection/posture.js";
import { Recording, Stream } from "./clock/sources.js";
import { describeBreaks } from "./studies/holding.js";
import { Sketch, UNSEEN } from "./sketch/sketch.js";
import { Sections } from "./studies/sections.js";
import { Setup, describeLimits } from "./panels/setup.js";
import { EnergyTable, ForceTable, LedgerTable, wireTables } from "./panels/tables.js";
import { reach, wireSave, wireTabs } from "./panels/tabs.js";
import { layoutOf, openParcel, Table, unpack } from "./data/unpack.js";

// The viewer and the program stand in the page; their hashes in its policy admit them.
function run(bytes) {
  document.head.append(make("script", {}, new TextDecoder().decode(bytes)));
}

async function loadSetup(scene, layout, motion) {
  if (!scene.engine) return null;
  run(await unpack("program"));
  const machine = new Machine(scene.engine, globalThis.mecaniqueProgram);
  return new Setup(new Bench(machine, scene, layout), motion);
}

// What a page that computes can do besides: each follows the setup's motions.
function wireExtras(setup, { picture, layout, plots, clock }) {
  if (!setup) return null;
  const { scene } = picture;
  const hand = new Hand(picture, clock, setup);
  const modes = new Modes(setup, scene, picture);
  document.getElementById("dragging").hidden = false;
  if (scene.engine.switching) {
    setup.listeners.push(new Beside(setup, scene, layout, plots));
    return (seconds) => hand.tick(seconds);
  }
  const exaggerating = new Exaggerating(picture, layout, modes);
  const sections = new Sections(setup, plots, scene, layout);
  setup.listeners.push(new Beside(setup, scene, layout, plots), sections, exaggerating);
  document.getElementById("exaggerating").hidden = false;
  return (seconds) => {
    hand.tick(seconds);
    sections.extend();
  };
}

// When the first picture of the motion is on the screen, or the page is not seen. Until then there is
// no panel: to set its equations takes longer than all before.
function firstPicture() {
  return new Promise((done) => {
    requestAnimationFrame(() => setTimeout(done));
    setTimeout(done, UNSEEN);
  });
}

// Fewer pictures than this of a motion recorded show chords: the page computes it at once.
const FEW = 30;

const isShort = ({ engine }, { last, n }) =>
  engine && (n < FEW || engine.first + engine.duration - last > 1e-6 * engine.duration);

// What a page that computes shows first; to that of a live view the server gave the beginning.
function openSetup(setup, { picture, clock }) {
  const { engine, live } = picture.scene;
  if (isShort(picture.scene, clock.table)) setup.attempt(() => setup.computed());
  if (live) goLive(setup, engine, picture, clock);
  setup.open(location.hash);
}

function goLive(setup, { endless }, picture, clock) {
  if (endless) setup.goOnForever();
  wireComputing(picture.scene.live.id, picture, clock);
  findPlace(picture.camera);
}

function sourceOf(live, table, { clock, picture, plots }) {
  return live ? new Stream(live, picture, plots) : new Recording(table, clock, picture, plots);
}

const startsByItself = (live) => !live && !matchMedia("(prefers-reduced-motion: reduce)").matches;

function goStreamed(live, picture, transport) {
  wireLive(live, picture, transport);
  findPlace(picture.camera);
}

// A description at rest is looked into and bent; there is no time to play.
function wireInspection(picture) {
  if (!picture.scene.inspection) return null;
  document.getElementById("transport").hidden = true;
  const anatomy = new Anatomy(picture);
  wireFindings(anatomy);
  return { anatomy, posture: new Posture(picture) };
}

function wirePicture(picture, forces, transport, bars, inspection) {
  const keys = wireCameras(picture.camera, picture.scene);
  wireShow(picture, bars, inspection?.anatomy.switches ?? []);
  wireForces(picture);
  wireFreeBody(picture, forces);
  wireTooltip(picture.stage, picture.arrows);
  listenToKeys(transport, keys);
  picture.companion?.wire(document.getElementById("follow"));
}

// Whether an address asks for another motion than that with which the page was made.
const isAsked = ({ engine }) => engine && readFragment(location.hash, engine).changes.length > 0;

// What has meshes waits for the viewer, and so does what must be computed first.
function startSketch({ scene, layout, table, clock }) {
  if (scene.live || !scene.bodies.every(({ solids }) => solids)) return null;
  if (isShort(scene, table) || isAsked(scene)) return null;
  const sketch = new Sketch(document.getElementById("sketch"), scene, layout, table, clock);
  if (startsByItself(scene.live)) sketch.play();
  return sketch;
}

// What the page holds, before anything is drawn.
async function open() {
  const { header: scene, parts } = openParcel(await unpack("parcel"));
  if (scene.live) document.body.classList.add("moving");
  const layout = layoutOf(scene);
  const table = new Table(scene.table, parts[0]);
  const live = scene.live && !scene.engine ? new LiveClock(scene.live, layout.end) : null;
  return { scene, layout, table, live, clock: live ?? new Player(table), parts: parts.slice(1) };
}

// Builds the picture and what steers it.
async function build({ scene, layout, table, live, clock, parts }) {
  const picture = new Picture(scene, layout, table, parts, live !== null);
  const transport = new Transport(clock);
  const list = quantities(scene, layout, quantitiesBeside(scene, layout));
  const plots = new Plots(live?.history ?? table, clock, list, scene.fileName);
  plots.peaks.set("m", picture.stage.size);
  const forces = new ForceTable(scene, layout);
  const bars = new EnergyBars(scene, layout);
  bars.survey(table);
  const tables = [new LedgerTable(scene, layout), forces, bars];
  tables.push(new EnergyTable(scene, layout, table));
  if (!live) tables.push(new ModeStrips(scene, clock));

  const inspection = wireInspection(picture);
  wirePicture(picture, forces, transport, bars, inspection);
  wirePrint(picture.stage, plots, clock);
  wireSave(scene.fileName);
  wireMenus();
  wireCopies(document.getElementById("panel"));
  wireTables(document.getElementById("panel"));
  wireSplitter(document.getElementById("splitter"));

  const source = sourceOf(live, table, { clock, picture, plots });
  const motion = { source, picture, layout, plots, clock, transport, tables, bars };
  const setup = await loadSetup(scene, layout, new Motion(motion));
  picture.stage.resize();
  picture.camera.look(scene.planar ? "front" : "free");
  if (live) goStreamed(live, picture, transport);
  plots.refresh();
  describeLimits(describeBreaks(scene.breaks));
  const extras = wireExtras(setup, motion);
  if (setup) openSetup(setup, motion);
  window.mecanique = { ...picture, picture, layout, table, clock, plots, setup, inspection };
  const loop = new Loop(source, picture, tables, transport);
  loop.onframe = extras;
  return loop;
}

async function start() {
  wireEmbedding();
  wireTabs(document.querySelector("[role=tablist]"));
  const page = await open();
  listForces(page.scene);
  const sketch = startSketch(page);
  await sketch?.moved();
  run(await unpack("viewer"));
  await sketch?.moved();
  const loop = await build(page);
  window.mecanique.sketch = sketch;
  await sketch?.moved();
  if (startsByItself(page.live)) page.clock.play();
  loop.start();
  await firstPicture();
  performance.mark("drawn");
  sketch?.end();
  document.body.classList.add("moving");
  wireBreaking(document.getElementById("panel-equations"));
  reach();
  document.body.classList.add("ready");
}

start().catch((error) => {
  const notice = document.getElementById("notice");
  notice.hidden = false;
  notice.textContent = `This page could not be shown: ${error.message}`;
  throw error;
});
