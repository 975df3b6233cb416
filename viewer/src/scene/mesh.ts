// Surfaces of mesh files as geometries.

import * as THREE from "three";
import type { Surface } from "../data";

/** Faces that meet at a smaller angle are shaded as one round surface: its cosine, of 40°. As in crates/view/src/meshes/surface.rs. */
const CREASE = 0.766;

const known = new WeakMap<Surface, THREE.BufferGeometry>();

/** The geometry of a surface, made once. */
export function surfaceGeometry(surface: Surface): THREE.BufferGeometry {
  let geometry = known.get(surface);
  if (!geometry) {
    geometry = new THREE.BufferGeometry();
    const { places, normals } = corners(surface);
    geometry.setAttribute("position", new THREE.BufferAttribute(places, 3));
    geometry.setAttribute("normal", new THREE.BufferAttribute(normals, 3, true));
    known.set(surface, geometry);
  }
  return geometry;
}

/** Places and normals [1/127] of all corners of all triangles. */
function corners({ places, faces }: Surface): { places: Float32Array; normals: Int8Array } {
  const normalOf = faceNormals(places, faces);
  const { first, around } = facesAround(places.length / 3, faces);
  const corners = new Float32Array(3 * faces.length);
  const normals = new Int8Array(3 * faces.length);
  for (let i = 0; i < faces.length; i++) {
    const own = 4 * Math.floor(i / 3);
    let [x, y, z] = [0, 0, 0];
    for (let k = first[faces[i]]; k < first[faces[i] + 1]; k++) {
      const near = 4 * around[k];
      const cosine = normalOf[own] * normalOf[near] + normalOf[own + 1] * normalOf[near + 1] + normalOf[own + 2] * normalOf[near + 2];
      if (cosine < CREASE) continue;
      const area = normalOf[near + 3];
      x += area * normalOf[near]; y += area * normalOf[near + 1]; z += area * normalOf[near + 2];
    }
    const scale = 127 / (Math.hypot(x, y, z) || 1);
    normals.set([Math.round(x * scale), Math.round(y * scale), Math.round(z * scale)], 3 * i);
    corners.set(places.subarray(3 * faces[i], 3 * faces[i] + 3), 3 * i);
  }
  return { places: corners, normals };
}

/** Per face: unit normal, twice the area. */
function faceNormals(places: Float32Array, faces: Uint32Array): Float32Array {
  const normals = new Float32Array((4 * faces.length) / 3);
  const [a, b, c] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
  for (let i = 0; i < faces.length; i += 3) {
    a.fromArray(places, 3 * faces[i]);
    b.fromArray(places, 3 * faces[i + 1]).sub(a);
    c.fromArray(places, 3 * faces[i + 2]).sub(a);
    const normal = b.cross(c);
    const area = normal.length();
    normal.divideScalar(area || 1).toArray(normals, (4 * i) / 3);
    normals[(4 * i) / 3 + 3] = area;
  }
  return normals;
}

/** The faces at place `i` are `around[first[i]]` up to before `around[first[i + 1]]`. */
function facesAround(count: number, faces: Uint32Array): { first: Uint32Array; around: Uint32Array } {
  const first = new Uint32Array(count + 1);
  for (const place of faces) first[place + 1] += 1;
  for (let i = 0; i < count; i++) first[i + 1] += first[i];
  const next = first.slice();
  const around = new Uint32Array(faces.length);
  faces.forEach((place, i) => { around[next[place]++] = Math.floor(i / 3); });
  return { first, around };
}
