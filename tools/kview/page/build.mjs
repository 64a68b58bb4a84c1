// Bundles the page into one HTML file: node build.mjs OUT_HTML [OUT_C], where OUT_C holds it as an array for the server.
import { build } from "esbuild";
import { readFile, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const [html, c] = process.argv.slice(2);
const bundled = await build({
  entryPoints: [join(here, "src/main.ts")],
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2020",
  legalComments: "none",
  loader: { ".css": "text" },
  outdir: "out", // nothing is written there
  write: false,
  logLevel: "warning",
});
const script = bundled.outputFiles[0].text.replaceAll("</script", "<\\/script");
const style = await readFile(join(here, "node_modules/uplot/dist/uPlot.min.css"), "utf8");
const own = await readFile(join(here, "src/style.css"), "utf8");
const template = await readFile(join(here, "src/page.html"), "utf8");
const page = template.replace("/*style*/", () => style + own).replace("/*script*/", () => script);
await writeFile(html, page);
if (c) {
  const bytes = Buffer.from(page, "utf8");
  const lines = [];
  for (let i = 0; i < bytes.length; i += 32) lines.push(Array.from(bytes.subarray(i, i + 32)).join(",") + ",");
  await writeFile(
    c,
    `/* Made by tools/kview/page/build.mjs. */\n#include "kview/page.h"\n\nconst unsigned char kv_page[] = {\n${lines.join("\n")}\n};\nconst size_t kv_page_size = sizeof kv_page;\n`,
  );
}
