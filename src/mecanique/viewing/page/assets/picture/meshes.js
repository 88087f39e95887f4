// Robots' meshes: points and triangles as the maker packed them, and the normals they have.

import { readIntegers } from "../data/unpack.js";

const CREASE = Math.cos(Math.PI / 6); // faces that meet at less are seen as one smooth surface
const [OVER_LAST, OVER_FIRST, ELSEWHERE] = [0, 1, 2]; // ways into a triangle

// Triangle by triangle: over which edge of the one before it is entered, or the edge itself, and its
// third corner; then how each point differs from where it is expected.
export function unpackSurface({ points, triangles, step, low }, bytes, start) {
  let at = start;
  const read = (count) => {
    const column = new Float64Array(count);
    at = readIntegers(bytes, at, count, column);
    return column;
  };
  const ways = read(triangles);
  const written = ways.reduce((count, way) => count + (way === ELSEWHERE), 0);
  const [firsts, seconds, thirds] = [read(written), read(written), read(triangles)];
  const corners = new Uint32Array(3 * triangles);
  const expected = new Uint32Array(3 * points); // a point is expected at a + b - c
  let [met, edge] = [0, 0];
  const corner = (back, a, b, c) => {
    if (back) return met - back;
    expected.set([a, b, c], 3 * met);
    return met++;
  };
  let [i, j, m] = [0, 0, 0];
  for (let k = 0; k < triangles; k++) {
    let left = j;
    if (ways[k] === OVER_LAST) [left, i] = [i, m];
    else if (ways[k] === OVER_FIRST) j = m;
    else {
      i = corner(firsts[edge], met - 1, 0, 0);
      j = corner(seconds[edge++], i, 0, 0);
      left = i;
    }
    m = corner(thirds[k], i, j, left);
    corners.set([i, j, m], 3 * k);
  }
  const positions = new Float32Array(3 * points);
  const whole = new Float64Array(points);
  for (let axis = 0; axis < 3; axis++) {
    const moves = read(points);
    for (let k = 0; k < points; k++) {
      const [a, b, c] = [expected[3 * k], expected[3 * k + 1], expected[3 * k + 2]];
      whole[k] = moves[k] + (k ? whole[a] + whole[b] - whole[c] : 0);
      positions[3 * k + axis] = low[axis] + step * whole[k];
    }
  }
  return { positions, corners, end: at };
}

// Each triangle's normal, as long as twice its area.
function faceNormals(positions, corners) {
  const normals = new Float32Array(corners.length);
  for (let f = 0; f < corners.length; f += 3) {
    const [a, b, c] = [3 * corners[f], 3 * corners[f + 1], 3 * corners[f + 2]];
    const [ux, uy, uz] = [0, 1, 2].map((i) => positions[b + i] - positions[a + i]);
    const [vx, vy, vz] = [0, 1, 2].map((i) => positions[c + i] - positions[a + i]);
    normals.set([uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx], f);
  }
  return normals;
}

// The faces around each point: those of point p are faces[starts[p]] to faces[starts[p + 1] - 1].
function neighbors(corners, count) {
  const starts = new Uint32Array(count + 1);
  for (const p of corners) starts[p + 1] += 1;
  for (let p = 0; p < count; p++) starts[p + 1] += starts[p];
  const next = starts.slice();
  const faces = new Uint32Array(corners.length);
  corners.forEach((p, k) => (faces[next[p]++] = 3 * Math.floor(k / 3)));
  return { starts, faces };
}

// A corner's normal is the sum of those of the faces around it that its own face blends into.
function cornerNormals(positions, corners) {
  const face = faceNormals(positions, corners);
  const size = new Float32Array(face.length / 3);
  for (let f = 0; f < face.length; f += 3)
    size[f / 3] = Math.hypot(face[f], face[f + 1], face[f + 2]);
  const { starts, faces } = neighbors(corners, positions.length / 3);
  const normals = new Float32Array(3 * corners.length);
  for (let k = 0; k < corners.length; k++) {
    const own = 3 * Math.floor(k / 3);
    let [x, y, z] = [0, 0, 0];
    for (let i = starts[corners[k]]; i < starts[corners[k] + 1]; i++) {
      const f = faces[i];
      const along = face[own] * face[f] + face[own + 1] * face[f + 1] + face[own + 2] * face[f + 2];
      if (f !== own && along < CREASE * size[own / 3] * size[f / 3]) continue;
      x += face[f];
      y += face[f + 1];
      z += face[f + 2];
    }
    const length = Math.hypot(x, y, z) || 1;
    normals[3 * k] = x / length;
    normals[3 * k + 1] = y / length;
    normals[3 * k + 2] = z / length;
  }
  return normals;
}

function geometryOf(three, { positions, corners }) {
  const places = new Float32Array(3 * corners.length);
  corners.forEach((p, k) => {
    for (let i = 0; i < 3; i++) places[3 * k + i] = positions[3 * p + i];
  });
  const geometry = new three.BufferGeometry();
  geometry.setAttribute("position", new three.BufferAttribute(places, 3));
  geometry.setAttribute("normal", new three.BufferAttribute(cornerNormals(positions, corners), 3));
  return geometry;
}

// Hangs every mesh into its body's node; one that is drawn several times is unpacked once.
export function hangMeshes(three, { surfaces, drawn }, bytes, nodes) {
  let at = 0;
  const geometries = surfaces.map((surface) => {
    const unpacked = unpackSurface(surface, bytes, at);
    at = unpacked.end;
    return geometryOf(three, unpacked);
  });
  for (const { body, surface, rgba, matrix } of drawn) {
    const [red, green, blue, opacity] = rgba;
    const paint = new three.MeshPhongMaterial({
      opacity,
      transparent: opacity < 1,
      shininess: 18,
      specular: 0x222222,
    });
    paint.color.setRGB(red, green, blue);
    const mesh = new three.Mesh(geometries[surface], paint);
    mesh.matrixAutoUpdate = false;
    mesh.matrix.set(...matrix);
    mesh.castShadow = mesh.receiveShadow = true;
    nodes[body].add(mesh);
  }
}
