// Build the viewer of a report: `npm ci && npm run build` writes src/lostmotion/reporting/page/viewer.js, or the file named as an argument.
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { build } from "esbuild";

const here = new URL(".", import.meta.url);
const inputs = ["build.mjs", "package-lock.json", "src/cells.js", "src/main.js", "src/picture.js"];
const hash = createHash("sha256");
for (const name of inputs) hash.update(readFileSync(new URL(name, here)));
const licence = readFileSync(new URL("node_modules/three/LICENSE", here), "utf8").trim();

await build({
  absWorkingDir: new URL(".", here).pathname,
  entryPoints: ["src/main.js"],
  outfile: process.argv[2] ?? "../src/lostmotion/reporting/page/viewer.js",
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  charset: "utf8",
  legalComments: "inline",
  // A test compares the hash with that of the sources: whoever changes them without a build is told.
  banner: { js: `/*! sources sha256 ${hash.digest("hex")}\nContains three.js.\n${licence}\n*/` },
});
