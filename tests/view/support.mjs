// What the tests of kview share: a server, a browser, and a page whose errors are gathered.
import { spawn } from "node:child_process";
import { createRequire } from "node:module";
import { mkdtempSync } from "node:fs";
import { tmpdir } from "node:os";
import { join, resolve as whole } from "node:path";

/** Starts kview with a model in a folder of its own, `home`; resolves to its address and a way to end it. */
export function serve(kview, model, ...options) {
  const home = mkdtempSync(join(tmpdir(), "kview-home-"));
  const child = spawn(whole(kview), [whole(model), "--no-browser", ...options], { stdio: ["ignore", "pipe", "pipe"], cwd: home });
  return new Promise((resolve, reject) => {
    let text = "", said = "";
    child.stderr.on("data", (data) => (said += data));
    child.stdout.on("data", (data) => {
      text += data;
      if (text.includes("\n")) resolve({ address: text.trim(), child, home, stop: () => child.kill("SIGTERM") });
    });
    child.on("exit", (code) => reject(new Error(`kview ended with ${code}: ${said}`)));
  });
}

/** Chromium by playwright-core, which is looked for in a folder of node modules. */
export async function launch(modules) {
  const { chromium } = createRequire(join(modules, "x.js"))("playwright-core");
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"],
  });
}

/** A page of an address; what its script complains about is in `faults`. */
export async function visit(browser, address, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, bypassCSP: true, ...options });
  const page = await context.newPage();
  const faults = [];
  page.on("pageerror", (error) => faults.push(String(error)));
  page.on("console", (message) => message.type() === "error" && faults.push(message.text()));
  await page.goto(address);
  await page.waitForFunction(() => window.kview?.store.pose && window.kview.view.frames > 0, null, { timeout: 20000 });
  return { page, faults, context };
}
