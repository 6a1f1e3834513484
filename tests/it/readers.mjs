// Opens GLB files in Khronos's validator and in glTF Transform with meshoptimizer's decoder: readers.mjs FOLDER CASES,
// the folder with their packages, and cases as for readers.py. Exits 1 at the first that is faulty or another mesh.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";

const [folder, cases] = process.argv.slice(2);
const require = createRequire(pathToFileURL(`${folder}/package.json`));
const validator = require("gltf-validator");
// Node 18 requires no module that imports another.
const imported = (path) => import(pathToFileURL(`${folder}/node_modules/${path}`));
const { NodeIO } = await imported("@gltf-transform/core/dist/index.js");
const { EXTMeshoptCompression } = await imported("@gltf-transform/extensions/dist/index.js");
const { MeshoptDecoder } = await imported("meshoptimizer/index.js");

// What the validator tells of compression, which it does not know, and of images whose sides are no powers of two.
const MAY_TELL = ["UNSUPPORTED_EXTENSION", "UNUSED_OBJECT", "IMAGE_NPOT_DIMENSIONS"];

function expect(what, expected, found) {
  const [e, f] = [expected, found].map((value) => JSON.stringify(value));
  if (e !== f) throw new Error(`${what}: expected ${e.slice(0, 400)}, found ${f.slice(0, 400)}`);
}

async function validate(path, mayTell, report) {
  const { issues, info } = await validator.validateBytes(new Uint8Array(readFileSync(path)), { maxIssues: 0 });
  const told = issues.messages.map((message) => message.code);
  expect("errors and warnings", [0, 0], [issues.numErrors, issues.numWarnings]);
  expect("what else the validator tells", [], told.filter((code) => !mayTell.includes(code)));
  const { totalVertexCount, totalTriangleCount } = info;
  expect("counts in the validator", [report.vertices, report.triangles], [totalVertexCount, totalTriangleCount]);
}

// Triangles with all that their corners have, each from its least corner on, in order.
async function triangles(io, path) {
  const document = await io.read(path);
  const [primitive, ...others] = document.getRoot().listMeshes().flatMap((mesh) => mesh.listPrimitives());
  expect("further primitives", 0, others.length);
  const names = primitive.listSemantics().sort();
  const attributes = names.map((name) => primitive.getAttribute(name));
  const corner = (vertex) => attributes.flatMap((attribute) => attribute.getElement(vertex, [])).join(" ");
  const indices = Array.from(primitive.getIndices().getArray(), corner);
  const all = [];
  for (let i = 0; i < indices.length; i += 3) {
    const corners = indices.slice(i, i + 3);
    const least = corners.indexOf([...corners].sort()[0]);
    all.push([0, 1, 2].map((k) => corners[(least + k) % 3]).join(" | "));
  }
  const images = document.getRoot().listTextures().map((texture) => texture.getImage().length);
  const [x, y, z] = document.getRoot().listNodes()[0].getWorldTranslation();
  return { names, all: all.sort(), images, node: [x, y, z], vertices: attributes[0].getCount() };
}

await MeshoptDecoder.ready;
const io = new NodeIO().registerExtensions([EXTMeshoptCompression]);
io.registerDependencies({ "meshopt.decoder": MeshoptDecoder });
for (const { check, file, options, report } of JSON.parse(readFileSync(cases, "utf8"))) {
  if (!["glb", "compressed"].includes(check)) continue;
  try {
    await validate(file, /compression|texture/.test(options) ? MAY_TELL : [], report);
    const mesh = await triangles(io, file);
    expect("counts in glTF Transform", [report.vertices, report.triangles], [mesh.vertices, mesh.all.length]);
    const { offset, xy_scale } = report.map;
    expect("the node", [offset[0] * xy_scale[0], 0, -offset[1] * xy_scale[1]], mesh.node);
    if (check === "compressed") {
      expect("the mesh without compression", await triangles(io, file.replace("-compressed", "")), mesh);
    }
  } catch (error) {
    console.error(`${file} ${options}: ${error.stack}`);
    process.exit(1);
  }
}
