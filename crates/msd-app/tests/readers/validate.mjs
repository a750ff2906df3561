// Validates a GLB file by the validator of Khronos: `node validate.mjs MODULES FILE`.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const [modules, file] = process.argv.slice(2);
const validator = createRequire(modules + "/")("gltf-validator");
const report = await validator.validateBytes(new Uint8Array(readFileSync(file)));
const { numErrors, numWarnings } = report.issues;
console.log(JSON.stringify(report.info));
if (numErrors + numWarnings > 0) {
  console.error(JSON.stringify(report.issues.messages.slice(0, 10), null, 1));
  process.exit(1);
}
