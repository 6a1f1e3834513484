// The mesh in the page: a GLB, compressed by meshoptimizer, in base 64.

import { Mesh, Vector3 } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
// Plain JavaScript: the other decoder is WebAssembly, which the page's policy does not allow.
import { MeshoptDecoder } from 'meshoptimizer/reference';

// Its geometries, and how their coordinates come from those of the map: x, height and -y, less an origin, times factors.
export async function readMesh(base64) {
  const bytes = Uint8Array.from(atob(base64), digit => digit.charCodeAt(0));
  const gltf = await new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).parseAsync(bytes.buffer, '');
  const { offset, xy_scale: scale, z_scale: up } = gltf.asset.extras.terrabite;
  const geometries = [];
  // The node that holds them is moved by the origin: single precision would lose its digits.
  gltf.scene.traverse(object => object instanceof Mesh && geometries.push(object.geometry));
  const frame = {
    toMap: ({ x, y, z }) => [x / scale[0] + offset[0], -z / scale[1] + offset[1], y / up],
    fromMap: ([x, y, height]) => new Vector3((x - offset[0]) * scale[0], height * up, -(y - offset[1]) * scale[1]),
  };
  return { geometries, frame };
}
