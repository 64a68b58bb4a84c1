// kview's page in a browser: page.mjs MODULES KVIEW KMOB MODELS_DIR smoke|all|guide|PART [PICTURES_DIR]
import { execFileSync } from "node:child_process";
import { mkdtempSync, readdirSync, rmSync, statSync, copyFileSync, readFileSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { launch, serve, visit } from "./support.mjs";

const [modules, kview, kmob, models, which, pictures] = process.argv.slice(2);
const browser = await launch(modules), folder = mkdtempSync(join(tmpdir(), "kview-"));
let failed = 0, passed = 0;

function check(good, what) {
  if (good) ++passed;
  else {
    ++failed;
    console.error(`failed: ${what}`);
  }
}

/** Visits a model and does something with the page; every fault of its script is a failure. */
async function on(model, options, work) {
  const server = model.endsWith(".html") ? { address: `file://${model}`, stop() {} } : await serve(kview, model);
  try {
    const { page, faults, context } = await visit(browser, server.address, options);
    await work(page, server);
    check(!faults.length, `${model}: ${faults.join("; ")}`);
    await context.close();
  } catch (error) {
    check(false, `${model}: ${error}`);
  } finally {
    server.stop();
  }
}

const until = (page, condition, argument) => page.waitForFunction(condition, argument, { timeout: 15000 });

/** A slider that is set leads to the numbers that kmob tells of the pose, to the digits shown. */
async function slider(page, model, label, value) {
  const name = await page.evaluate((l) => kview.store.model.coordinates.findIndex((c) => c.label === l), label);
  const row = page.locator(`.row[data-coordinate="${name}"]`);
  await row.locator("input.value").fill(String(value));
  await row.locator("input.value").press("Enter");
  await until(page, ([i, v]) => Math.abs(kview.store.pose.q[i] - v) < 1e-12, [name, value]);
  const record = JSON.parse(execFileSync(kmob, ["at", model, "--set", `${label}=${value}`, "--format", "json", "--quiet"]));
  const shown = await page.evaluate(() => [...document.querySelectorAll(".row")].map((r) => [Number(r.dataset.coordinate), r.querySelector(".number").textContent]));
  const labels = await page.evaluate(() => kview.store.model.coordinates.map((c) => c.label));
  for (const [coordinate, text] of shown)
    if (coordinate >= 0) check(text === record.mobility_numbers[labels[coordinate]].toFixed(4), `${model}: the number of ${labels[coordinate]} at ${label} = ${value}: ${text}`);
}

/** A body dragged by the mouse follows, with the loops closed. */
async function drag(page, model) {
  const box = await page.locator("canvas").first().boundingBox();
  const spot = await page.evaluate(() => {
    const { view } = kview, box = view.canvas.getBoundingClientRect();
    let best = null;
    for (let i = 0; i < 2500; ++i) {
      const x = box.left + ((i * 37) % 97) / 97 * box.width, y = box.top + ((i * 61) % 89) / 89 * box.height;
      const hit = view.hit({ clientX: x, clientY: y });
      if (hit && hit.kind === "body" && hit.index > (best?.body ?? 0)) best = { x, y, body: hit.index };
    }
    return best;
  });
  if (!spot) return check(false, `${model}: no body is seen`);
  const before = await page.evaluate(() => Array.from(kview.store.pose.q));
  await page.mouse.move(spot.x, spot.y);
  await page.mouse.down();
  for (let k = 1; k <= 12; ++k) {
    await page.mouse.move(spot.x + (k * box.width) / 150, spot.y - (k * box.height) / 170);
    await page.waitForTimeout(16);
  }
  await page.waitForTimeout(150);
  await page.mouse.up();
  const after = await page.evaluate(() => ({ q: Array.from(kview.store.pose.q), residual: kview.store.pose.residual }));
  check(after.residual <= 1e-9, `${model}: loops are open by ${after.residual} after a drag`);
  return after.q.some((q, i) => q !== before[i]);
}

async function smoke() {
  const model = join(models, "excavator.json");
  await on(model, {}, async (page) => {
    await until(page, () => kview.store.table);
    await slider(page, model, "M", 2.8);
    check(await drag(page, model), `${model}: a drag moves nothing`);
    await page.keyboard.press("Control+z");
    const end = await page.evaluate(() => kview.store.ask("point 5 1.2 -0.3 0 30 0 0 0 1 0"));
    check(end.kind === "pose", `${model}: ${JSON.stringify(end)}`);
  });
  const out = join(folder, "klann.html");
  execFileSync(kview, ["export", join(models, "klann.json"), "-o", out, "--quiet"]);
  check(statSync(out).size <= 2 << 20, `the exported page has ${statSync(out).size} bytes`);
  await on(out, {}, async (page) => {
    await until(page, () => kview.store.table);
    const before = await page.evaluate(() => kview.store.pose.q[0]);
    await page.locator(".row input[type=range]").first().fill("2");
    check((await page.evaluate(() => kview.store.pose.q[0])) !== before, "the exported page's slider moves nothing");
    await page.getByLabel("Question").selectOption({ label: "Actuator forces" });
    await until(page, () => kview.store.table.question === "forces");
  });
}

async function everyModel() {
  for (const file of readdirSync(models).filter((f) => f.endsWith(".json")).sort()) {
    const model = join(models, file);
    await on(model, {}, async (page) => {
      await page.waitForTimeout(300);
      await drag(page, model);
    });
  }
}

/** The slider of a slider-crank stops at its dead point and says so; the crank passes it. */
async function toggles() {
  const model = join(models, "slider_crank.json");
  await on(model, {}, async (page) => {
    const index = (label) => page.evaluate((l) => kview.store.model.coordinates.findIndex((c) => c.label === l), label);
    const b = await index("B"), a = await index("A");
    await page.evaluate((i) => kview.store.pull(`joint ${i} 100`, () => true), b);
    await until(page, () => kview.store.pose.stop === "toggle");
    check((await page.locator(".status").textContent()).includes("toggle"), "the toggle isn't told");
    await page.evaluate((i) => kview.store.pull(`joint ${i} ${kview.store.pose.q[i] + 2}`, () => true), a);
    await until(page, () => kview.store.pose.there);
    check(await page.evaluate(() => kview.store.pose.residual <= 1e-9), "the loops are open behind the toggle");
  });
}

/** A pivot that is dragged changes the curve while the file's stays; undo brings it back; a variant is kept. */
async function design() {
  const model = join(models, "brake.json");
  await on(model, {}, async (page) => {
    await until(page, () => kview.store.table);
    const joint = await page.evaluate(() => kview.store.model.joints.findIndex((j) => j.label === "D"));
    await page.keyboard.press("d");
    await page.evaluate((j) => kview.store.select({ kind: "joint", index: j }), joint);
    const fields = page.locator(".pivot input"), first = await page.evaluate(() => Array.from(kview.store.table.values[kview.store.table.values.length - 1]));
    const at = Number((await fields.nth(0).inputValue()).replace("−", "-"));
    await fields.nth(0).fill(String(at + 0.5));
    await fields.nth(0).press("Enter");
    await until(page, () => kview.store.model.edited);
    await until(page, (old) => kview.store.table.values[kview.store.table.values.length - 1].some((v, i) => v !== old[i]), first); // the curve follows
    check(await page.evaluate(() => kview.store.base && kview.store.base !== kview.store.table), "the file's own curve is lost");
    await page.getByRole("button", { name: "Keep this design" }).click();
    check(await page.evaluate(() => kview.store.variants.length === 1), "no variant is kept");
    await page.keyboard.press("Escape");
    await page.locator("canvas").first().focus();
    await page.keyboard.press("Control+z");
    await until(page, () => !kview.store.model.edited);
  });
}

/** Bricard's linkage is pulled round, by whichever of two neighbours can move, through the planar poses where the other one
 * stands: never open, never a jump. */
async function bricard() {
  await on(join(models, "bricard.json"), {}, async (page) => {
    const found = await page.evaluate(async () => {
      const { store } = kview, index = (label) => store.model.coordinates.findIndex((c) => c.label === label);
      const pair = [index("A"), index("B")], sense = [1, 1], out = { open: 0, jump: 0, way: 0, planar: 0, error: "" };
      for (let k = 0; k < 400; ++k) {
        const before = Array.from(store.pose.q), m = store.pose.m, which = m[pair[0]] > m[pair[1]] ? 0 : 1, c = pair[which];
        const answer = await store.ask(`joint ${c} ${before[c] + 0.08 * sense[which]}`);
        if (answer.kind !== "pose") return { ...out, error: JSON.stringify(answer) };
        const moved = Array.from(answer.q, (v, i) => v - before[i]);
        pair.forEach((p, i) => (sense[i] = moved[p] !== 0 ? Math.sign(moved[p]) : sense[i]));
        out.open = Math.max(out.open, answer.residual);
        out.jump = Math.max(out.jump, ...moved.map(Math.abs));
        out.way += Math.abs(moved[pair[0]]);
        out.planar += pair.some((p) => answer.m[p] < 1e-3) ? 1 : 0;
      }
      return out;
    });
    check(found.open <= 1e-9 && !found.error, `Bricard's loop is open by ${found.open} ${found.error}`);
    check(found.jump < 0.5, `Bricard's linkage jumps by ${found.jump}`);
    check(found.way > 6 && found.planar >= 2, `Bricard's linkage doesn't come round: ${JSON.stringify(found)}`);
  });
}

const flat = {
  model_parameters: { version: "1.1", units: { length: "mm", angle: "deg" } },
  parameters: { crank: { value: 40, low: 20, high: 80, note: "length of the crank" } },
  poses: { up: { A: 120 } },
  assemblies: [{
    name: "parallelogram", drawn: "assembled", bodies: [{ name: "crank" }, { name: "coupler" }, { name: "rocker" }],
    joints: [["A", "fixed", "crank", 0], ["B", "crank", "coupler", "crank"], ["C", "coupler", "rocker", "100+crank"], ["D", "fixed", "rocker", 100]].map(([name, from, to, x]) => ({ name, type: "revolute", bodies: [from, to], at: [x, 0] })),
  }],
  analysis: { sweep: { arclength: 0.05, steps: 200 } },
};

/** A parallelogram laid flat goes on along any of the motions that meet there; poses and parameters go by their names. */
async function names() {
  const file = join(folder, "flat.json");
  writeFileSync(file, JSON.stringify(flat));
  await on(file, {}, async (page) => {
    await until(page, () => kview.store.table?.branches === 2);
    const last = () => page.evaluate(() => kview.store.table.values.map((v) => v[v.length - 1]));
    const smooth = await last(), choice = page.getByLabel("At the branch point");
    check((await choice.locator("option").count()) === 3, "three ways on are offered where two motions meet");
    await page.evaluate(() => (kview.store.table = null));
    await choice.selectOption("2");
    await until(page, () => kview.store.table);
    check((await last()).some((v, i) => Math.abs(v - smooth[i]) > 1), "the other motion is the smooth one");
    await page.getByLabel("Parameter crank").fill("55");
    await page.getByLabel("Parameter crank").press("Enter");
    await until(page, () => kview.store.model.edited && kview.store.model.parameters[0].value === 55);
    const text = await page.evaluate(async () => (await kview.store.ask("write")).text);
    check(JSON.parse(text).parameters.crank.value === 55, "the file that is saved has the old parameter");
    await page.getByLabel("Poses of the model").selectOption("0");
    await until(page, () => Math.abs(kview.store.pose.q[0] - 120) < 1e-6);
    await page.getByLabel("Parameter crank").fill("50");
    await page.getByLabel("Parameter crank").press("Enter");
    await until(page, () => kview.store.model.parameters[0].value === 50);
    check(await page.evaluate(() => Math.abs(kview.store.pose.q[0] - 120) < 1e-6 && kview.store.pose.residual <= 1e-9), "the pose isn't kept when a parameter changes");
    await page.getByLabel("Parameter crank").fill("five");
    await page.getByLabel("Parameter crank").press("Enter");
    await until(page, () => document.querySelector(".status").textContent.includes("needs a number"));
  });
}

/** An arm's columns are arrows at its joints, and a click into the map of its self-motion takes it there in place. */
async function arm() {
  await on(join(models, "iiwa14.json"), {}, async (page) => {
    await page.getByRole("button", { name: "Show path-control" }).click();
    await until(page, () => kview.store.columns && kview.view.marks.children.length > 0);
    const { columns, rates } = await page.evaluate(() => ({ columns: kview.store.columns.columns.length, rates: kview.store.columns.columns[1] }));
    check(columns === 2 && rates.some((r) => Math.abs(r) > 0.1), `an arm of seven joints has ${columns} columns`);
    await page.getByRole("button", { name: "Find the poses that hold" }).click();
    await page.locator("svg.map").waitFor();
    const place = () => page.evaluate(() => Array.from(kview.store.pose.bodies.slice(-3)));
    const before = await place(), q = await page.evaluate(() => Array.from(kview.store.pose.q));
    await page.locator("svg.map").click({ position: { x: 30, y: 40 } });
    await until(page, (old) => kview.store.pose.q.some((v, i) => Math.abs(v - old[i]) > 1e-3), q);
    const after = await place();
    check(after.every((v, i) => Math.abs(v - before[i]) < 1e-5), `the effector moves by ${after.map((v, i) => v - before[i])}`);
  });
}

/** The map of a five-bar: a click goes to the drivers there, on the sheet that is shown, and loops stay closed. */
async function map() {
  await on(join(models, "five_bar.json"), {}, async (page) => {
    await until(page, () => kview.store.pose);
    await page.getByRole("button", { name: "Find the configurations over both drivers" }).click();
    const picture = page.locator("canvas.map");
    await picture.waitFor();
    await picture.scrollIntoViewIfNeeded();
    await page.waitForTimeout(300); // the fine map follows the first one
    const pose = () => page.evaluate(() => ({ q: Array.from(kview.store.pose.q), residual: kview.store.pose.residual }));
    const box = await picture.boundingBox(), first = await pose();
    const click = (x, y) => page.mouse.click(box.x + x * box.width, box.y + y * box.height);
    await click(0.6, 0.45); // A from -pi to pi across, E upwards
    await until(page, (q) => kview.store.pose.q[0] !== q, first.q[0]);
    await page.waitForTimeout(100);
    const at = await pose();
    check(Math.abs(at.q[0] - 0.2 * Math.PI) < 0.12 && Math.abs(at.q[4] - 0.1 * Math.PI) < 0.12, `a click into the map leads to ${at.q}`);
    check(at.residual <= 1e-9, "the loops are open after a click into the map");
    await page.getByRole("button", { name: "sheet 2" }).click();
    await click(0.6, 0.45);
    await until(page, (q) => Math.abs(kview.store.pose.q[2] - q) > 0.5, at.q[2]);
    check((await pose()).residual <= 1e-9, "the loops are open on the other sheet");
    check(Math.sign((await pose()).q[2]) !== Math.sign(at.q[2]), "the other sheet isn't the other mode");
    await until(page, () => [...document.querySelectorAll('.chip[aria-pressed="true"]')].some((chip) => chip.textContent === "sheet 2"));
    await picture.focus();
    const before = await pose();
    await page.keyboard.press("ArrowRight");
    await until(page, (q) => kview.store.pose.q[0] > q, before.q[0]);
    if (pictures) await page.screenshot({ path: join(pictures, "kview.map.png") });
    await workspace(page, picture, click, pose);
  });
}

const idle = (page) => until(page, () => !document.querySelector('button[aria-label="Stop finding the map"]'));

/** Over a point: a click goes to a configuration with the point there, the outline is drawn; a map that is stopped leaves the page usable. */
async function workspace(page, picture, click, pose) {
  await idle(page);
  await page.getByLabel("Point whose workspace is found").selectOption({ label: "rod1/P" });
  await page.getByRole("button", { name: "over the point" }).waitFor();
  await idle(page);
  const says = await page.locator("canvas.map + .hint").textContent();
  check(/area 3\.5596\d* m², 2 holes/.test(says), `the workspace is told as ${says}`);
  const before = await pose();
  await picture.scrollIntoViewIfNeeded();
  const box = await picture.boundingBox();
  const place = () => page.evaluate(() => {
    const { model, pose } = kview.store, f = model.frames.find((frame) => frame.name === "P"), b = 12 * f.body;
    return [0, 1].map((i) => [0, 1, 2].reduce((s, k) => s + pose.bodies[b + 3 * i + k] * f.T[k], pose.bodies[b + 9 + i]));
  });
  const at = await place();
  const side = 1.04 * 2 * Math.SQRT2; // of the picture: the lens of both circles of 1.5 m is so high; its middle is between the pins
  const target = [at[0] - 0.3, at[1] - 0.2];
  await page.mouse.click(box.x + (0.5 + (target[0] - 0.5) / side) * box.width, box.y + (0.5 - target[1] / side) * box.height);
  await until(page, (q) => kview.store.pose.q.some((v, i) => Math.abs(v - q[i]) > 1e-3), before.q);
  await page.waitForTimeout(100);
  const there = await place();
  check(Math.hypot(there[0] - target[0], there[1] - target[1]) < 0.15, `a click at ${target} leads to ${there}`);
  check((await pose()).residual <= 1e-9, "the loops are open after a click into the workspace");
  if (pictures) await page.screenshot({ path: join(pictures, "kview.workspace.png") });
  await page.getByRole("button", { name: "Find the configurations over both drivers" }).click();
  await page.getByRole("button", { name: "Stop finding the map" }).click();
  await idle(page);
  check(await picture.isVisible(), "no map is shown after one was stopped");
  const last = await pose();
  await picture.focus();
  await page.keyboard.press("ArrowLeft");
  await until(page, (q) => kview.store.pose.q.some((v, i) => Math.abs(v - q[i]) > 1e-3), last.q);
}

/** A file that changes is read again; one that is wrong is told with its place. */
async function reload() {
  const file = join(folder, "fourbar.json"), text = readFileSync(join(models, "fourbar.json"), "utf8");
  copyFileSync(join(models, "fourbar.json"), file);
  await on(file, {}, async (page) => {
    writeFileSync(file, text.replace('"joints"', '"joint"'));
    await until(page, () => document.querySelector(".status").classList.contains("alert"));
    writeFileSync(file, text);
    await until(page, () => document.querySelector(".status").textContent.includes("read again"));
  });
}

/** What is shown belongs to the pose and the model that are there: forces after a joint is held, the curve after another mode is taken,
 * why a curve ends early; axis numbers of any length are whole. */
async function belongs() {
  await on(join(models, "excavator.json"), {}, async (page) => {
    await until(page, () => kview.store.table);
    await page.getByRole("button", { name: "Show loads and reactions" }).click();
    await until(page, () => kview.store.forces);
    const held = await page.evaluate(() => kview.store.forces.actuators[0].coordinate);
    await page.evaluate((c) => kview.store.ask(`hold ${c} 1`), held);
    await until(page, (c) => kview.store.model.coordinates[c].held && (!kview.store.forces || !kview.store.forces.actuators.some((a) => a.coordinate === c)), held);
  });
  await on(join(models, "fourbar.json"), {}, async (page) => {
    await until(page, () => kview.store.table);
    const old = await page.evaluate(() => { window.old = kview.store.table; return Array.from(kview.store.pose.q); });
    await page.evaluate(() => (kview.store.model.sweep.driver = 0));
    await page.locator(".group", { hasText: "Assembly modes" }).getByRole("button", { name: "Find" }).click();
    await page.getByRole("button", { name: "Take assembly mode 2" }).click();
    await until(page, (q) => kview.store.pose.q.some((v, i) => Math.abs(v - q[i]) > 0.1) && kview.store.table !== window.old, old);
    const misfit = await page.evaluate(() => {
      const { table, pose, model } = kview.store, s = Array.from(table.values[1]), at = s.reduce((b, x, r) => (Math.abs(x - pose.q[table.driver]) < Math.abs(s[b] - pose.q[table.driver]) ? r : b), 0);
      return Math.max(...model.coordinates.map((c, i) => { const d = table.values[table.columns.findIndex((k) => k.name === `q.${c.label}`)][at] - pose.q[i]; return Math.abs(d - 2 * Math.PI * Math.round(d / (2 * Math.PI))); }));
    });
    check(misfit < 0.1, `the curve is another mode's: off by ${misfit}`);
    await page.getByLabel("Driver").selectOption({ label: "D" });
    await page.getByLabel("From", { exact: true }).fill("-3");
    await page.getByLabel("From", { exact: true }).press("Enter");
    await until(page, () => kview.store.table.stopped && document.querySelector(".curves .hint").textContent.includes("in line"));
  });
}

/** Copied poses are poses for kmob; designs outlive a page that is loaded again, a file that is written again, and kview itself; a
 * parameter moves a pivot that was dragged; the seventeenth page is told why it can't be had. */
async function kept() {
  const file = join(folder, "kept.json");
  writeFileSync(file, JSON.stringify(flat));
  await on(file, { permissions: ["clipboard-read", "clipboard-write"] }, async (page, server) => {
    await until(page, () => kview.store.table);
    await page.evaluate(() => kview.store.pull("joint 0 30 10", () => true));
    await until(page, () => Math.abs(kview.store.pose.q[0] - 30) < 1e-9);
    await page.evaluate(() => kview.store.settle());
    await page.getByRole("button", { name: "Copy the pose" }).click();
    await until(page, () => /copied|--set/.test(kview.store.message));
    const words = await page.evaluate(() => (kview.store.message.startsWith("--set") ? kview.store.message : navigator.clipboard.readText()));
    check(words.split(" ").length === 2, `one freedom, and ${words} is copied`);
    execFileSync(kmob, ["at", file, ...words.split(" ")]);
    await page.getByLabel("Parameter crank").fill("55");
    await page.getByLabel("Parameter crank").press("Enter");
    await until(page, () => kview.store.model.parameters[0].value === 55);
    page.on("dialog", (dialog) => void dialog.accept());
    await page.reload();
    await until(page, () => kview.store?.model?.parameters?.[0].value === 55 && kview.store.model.edited);
    writeFileSync(file, JSON.stringify(flat) + " ");
    await until(page, () => document.querySelector(".status").textContent.includes("was kept"));
    check(await page.evaluate(() => kview.store.model.parameters[0].value === 55 && kview.store.first.length === 3 * kview.store.model.frames.length), "the design is lost with the file");
    const others = [];
    for (let i = 0; i < 15; ++i) others.push(await page.context().newPage().then(async (other) => (await other.goto(server.address), other)));
    for (const other of others) await until(other, () => window.kview?.store?.model);
    const last = await page.context().newPage();
    await last.goto(server.address);
    await until(last, () => document.querySelector(".status").textContent.includes("16 pages are open"));
    for (const other of [...others, last]) await other.close();
    const over = new Promise((told) => server.child.on("exit", told));
    server.stop();
    await over;
    check(JSON.parse(readFileSync(join(server.home, "kept.unsaved.json"), "utf8")).parameters.crank.value === 55, "the design is lost with kview");
  });
}

/** Every control has a name, and nothing is wider than the window. */
async function sizes() {
  for (const [width, height] of [[1600, 1000], [1000, 760], [390, 844]])
    for (const colorScheme of ["light", "dark"])
      await on(join(models, "excavator.json"), { viewport: { width, height }, colorScheme, hasTouch: width < 500 }, async (page) => {
        await until(page, () => kview.store.table);
        await page.waitForTimeout(400);
        const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
        check(wide <= 0, `${width} ${colorScheme}: wider than the window by ${wide}`);
        const out = await page.evaluate(() => {
          const box = { x: 0, y: 0 };
          kview.view.actors.corners((p) => {
            const spot = p.clone().project(kview.view.camera);
            box.x = Math.max(box.x, Math.abs(spot.x));
            box.y = Math.max(box.y, Math.abs(spot.y));
          });
          return Math.max(box.x, box.y);
        });
        check(out < 1, `${width} ${colorScheme}: the mechanism is cut off at ${out} of the view's half`);
        const nameless = await page.evaluate(() => [...document.querySelectorAll("button, input, select")].filter((n) => !(n.getAttribute("aria-label") || n.textContent.trim() || n.labels?.length)).map((n) => n.outerHTML));
        check(!nameless.length, `without a name: ${nameless.slice(0, 3)}`);
        if (pictures) await page.screenshot({ path: join(pictures, `kview.${width}.${colorScheme}.png`) });
      });
}

/** The pictures of docs/kview.md. */
async function guide() {
  await on(join(models, "excavator.json"), {}, async (page) => {
    await until(page, () => kview.store.table);
    for (let k = 0; k < 8; ++k) await page.evaluate(() => kview.store.ask("point 5 1.2 -0.3 0 6 -1 1.2 0 0 0"));
    await page.evaluate(() => {
      kview.store.select({ kind: "joint", index: kview.store.model.joints.findIndex((j) => j.label === "O") });
      kview.store.say("");
    });
    await page.waitForTimeout(500);
    await page.screenshot({ path: join(pictures, "kview.excavator.png") });
  });
}

const parts = { toggles, belongs, kept, design, reload, bricard, names, arm, map, sizes, everyModel };
if (which === "guide") await guide();
else if (which in parts) await parts[which]();
else await smoke();
if (which === "all") for (const part of Object.values(parts)) await part();
await browser.close();
rmSync(folder, { recursive: true });
console.log(`${passed} passed, ${failed} failed`);
process.exit(failed ? 1 : 0);
