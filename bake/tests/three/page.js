// Shows a glTF file as it is: its camera, no light, no tone map. Gives linear radiance.

import * as THREE from "three";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

/** Light maps as three.js reads them: texel · intensity is irradiance. Its GLTFLightMapLoaderExtension does the same in newer versions. */
class LightMaps {
  name = "MOZ_lightmap";

  constructor(parser) {
    this.parser = parser;
  }

  loadMaterial(number) {
    const map = this.parser.json.materials[number].extensions?.[this.name];
    if (!map) return null;
    return Promise.all([this.parser.loadMaterial(number), this.parser.getDependency("texture", map.index)]).then(([material, texture]) => {
      texture.channel = map.texCoord ?? 1;
      material.lightMap = texture;
      material.lightMapIntensity = map.intensity ?? 1;
      return material;
    });
  }
}

/** The radiance of a file's picture, row by row from the top: the mean over `samples`² points of each pixel. */
globalThis.show = async (url, [width, height], samples) => {
  const loader = new GLTFLoader().register((parser) => new LightMaps(parser));
  const { scene, cameras } = await loader.loadAsync(url);
  const camera = cameras[0];
  camera.aspect = width / height;
  camera.updateProjectionMatrix();
  // Lights of the file are in its maps.
  scene.traverse((node) => (node.intensity = node.isLight ? 0 : node.intensity));
  const renderer = new THREE.WebGLRenderer();
  const [w, h] = [width * samples, height * samples];
  const target = new THREE.WebGLRenderTarget(w, h, { type: THREE.FloatType, colorSpace: THREE.LinearSRGBColorSpace });
  renderer.setRenderTarget(target);
  renderer.render(scene, camera);
  const pixels = new Float32Array(4 * w * h);
  renderer.readRenderTargetPixels(target, 0, 0, w, h, pixels);
  const radiance = new Float32Array(3 * width * height);
  for (let y = 0; y < h; y++) {
    for (let x = 0; x < w; x++) {
      const from = 4 * ((h - 1 - y) * w + x);
      const to = 3 * (Math.floor(y / samples) * width + Math.floor(x / samples));
      for (let k = 0; k < 3; k++) radiance[to + k] += pixels[from + k] / samples ** 2;
    }
  }
  renderer.dispose();
  let text = "";
  const bytes = new Uint8Array(radiance.buffer);
  for (let at = 0; at < bytes.length; at += 1 << 14) text += String.fromCharCode(...bytes.subarray(at, at + (1 << 14)));
  return btoa(text);
};
globalThis.isReady = true;
