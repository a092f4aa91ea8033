// Compares Kubernetes manifests with the schemas of their kinds, and finds keys that no schema has.
// usage: node check.mjs FILE...    one line per mistake; exit 1 if there is any. Runs where node_modules is.
// The schemas are those of kubernetes-models, which are made from Kubernetes' OpenAPI description. They accept unknown keys; its
// TypeScript declarations do not.
import {readFileSync, rmSync, writeFileSync} from "node:fs";
import {createRequire} from "node:module";
import path from "node:path";
import ts from "typescript";
import yaml from "yaml";

const require = createRequire(import.meta.url);

/** The module that has the kinds of an apiVersion. */
const moduleOf = (manifest) => `kubernetes-models/${manifest.apiVersion}`;

function schemaMistakes(manifest) {
  const Kind = require(moduleOf(manifest))[manifest.kind];
  if (!Kind) return [`${manifest.apiVersion} has no kind ${manifest.kind}`];
  try {
    new Kind(manifest).validate();
    return [];
  } catch (error) {
    return [error.message];
  }
}

/** A literal of the manifest's type: TypeScript refuses keys that the type does not have. */
function typeMistakes(manifest) {
  const source = path.resolve(`manifest-${process.pid}.ts`);
  writeFileSync(source, `import type {I${manifest.kind}} from "${moduleOf(manifest)}";\n` +
    `export const manifest: I${manifest.kind} = ${JSON.stringify(manifest, null, 1)};\n`);
  const program = ts.createProgram([source], {strict: true, noEmit: true, skipLibCheck: true, types: [], module: ts.ModuleKind.Node16,
    moduleResolution: ts.ModuleResolutionKind.Node16});
  const mistakes = ts.getPreEmitDiagnostics(program).map((found) => ts.flattenDiagnosticMessageText(found.messageText, " "));
  rmSync(source);
  return mistakes;
}

let wrong = 0;
for (const file of process.argv.slice(2)) {
  for (const document of yaml.parseAllDocuments(readFileSync(file, "utf8"), {version: "1.1"})) {
    if (document.errors.length > 0) throw document.errors[0];
    const manifest = document.toJS();
    const name = `${file}: ${manifest.kind} ${manifest.metadata?.name}`;
    for (const mistake of [...schemaMistakes(manifest), ...typeMistakes(manifest)]) {
      console.log(`${name}: ${mistake}`);
      ++wrong;
    }
    console.log(`${name}: checked`);
  }
}
process.exitCode = wrong > 0 ? 1 : 0;
