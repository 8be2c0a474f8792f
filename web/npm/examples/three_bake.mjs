// Bakes light into the vertex colours of meshes of three.js: soft shadows of area lights, without a shadow map. In Node or in a browser.

import { BufferAttribute, Mesh, MeshBasicMaterial, PlaneGeometry, TorusKnotGeometry } from "three";
import { Light, Renderer, Scene, init } from "cosine-lobes";

/** The arrays of a mesh in world space. */
function arraysOf(mesh) {
  mesh.updateWorldMatrix(true, false);
  const geometry = mesh.geometry.clone().applyMatrix4(mesh.matrixWorld);
  const { position, normal } = geometry.attributes;
  return { positions: position.array, normals: normal.array, triangles: geometry.index?.array ?? null };
}

/**
 * Gives each mesh an attribute `color`: the radiance of a white diffuse surface at each vertex, that is irradiance over π. A
 * `MeshBasicMaterial` with `vertexColors` shows it times its own colour, as a diffuse surface of that albedo.
 */
export function bake(meshes, lights) {
  const scene = new Scene();
  const all = meshes.map(arraysOf);
  const numbers = all.map(({ positions, triangles, normals }) => scene.addMesh(positions, triangles, { normals }));
  lights.forEach((light) => scene.addLight(light));
  const renderer = new Renderer(scene, { keepPoints: false });
  scene.free();
  try {
    all.forEach(({ positions, normals }, k) => {
      const radiance = renderer.shade(positions, normals, null, { objects: numbers[k] });
      meshes[k].geometry.setAttribute("color", new BufferAttribute(radiance, 3));
    });
  } finally {
    renderer.free();
  }
}

await init();
const material = new MeshBasicMaterial({ color: 0xc0c0c0, vertexColors: true });
export const floor = new Mesh(new PlaneGeometry(8, 8, 96, 96).rotateX(-Math.PI / 2), material);
export const knot = new Mesh(new TorusKnotGeometry(0.6, 0.2, 96, 16), material);
knot.position.y = 1.2;

const begin = performance.now();
bake([floor, knot], [Light.sphere([1.5, 4, 1], 0.4, { radiance: 30 }), Light.rectangle([-3, 3, 0], [0, 0, 0.5], [0.5, 0.5, 0], { radiance: 12 })]);
const vertices = [floor, knot].reduce((sum, { geometry }) => sum + geometry.attributes.position.count, 0);
console.log(`${vertices} vertices baked in ${((performance.now() - begin) / 1000).toFixed(2)} s`);
