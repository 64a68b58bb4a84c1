// Who comes in, and what rude clients do to the server: socket.mjs KVIEW MODEL
import { randomBytes } from "node:crypto";
import { readFileSync } from "node:fs";
import { connect } from "node:net";
import { serve } from "./support.mjs";

const [kview, model] = process.argv.slice(2);
const server = await serve(kview, model, "--stay");
const { port, pathname, hostname } = new URL(server.address);
let failed = 0, passed = 0;

function check(good, what) {
  if (good) ++passed;
  else {
    ++failed;
    console.error(`failed: ${what}`);
  }
}

const wait = (ms) => new Promise((done) => setTimeout(done, ms));
const memory = () => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${server.child.pid}/status`, "utf8"))[1]); // kB
const own = `http://127.0.0.1:${port}`;

/** What comes back for bytes, until the connection ends or a time is over. */
function send(bytes, time = 10000) {
  return new Promise((done) => {
    let text = "";
    const socket = connect(Number(port), hostname, () => socket.write(bytes));
    const end = () => {
      socket.destroy();
      done(text);
    };
    socket.on("data", (data) => {
      text += data.toString("latin1");
      if (text.includes("\r\n\r\n")) end();
    });
    socket.on("error", end).on("close", end);
    setTimeout(end, time);
  });
}

const get = (path, host = `127.0.0.1:${port}`) => send(`GET ${path} HTTP/1.1\r\nHost: ${host}\r\n\r\n`);

/** A WebSocket by hand: what it got, and how to send a text. */
function open({ path = `${pathname}ws`, origin = own, host = `127.0.0.1:${port}`, protocol = "kview", read = true } = {}) {
  return new Promise((done) => {
    const head = [`GET ${path} HTTP/1.1`, `Host: ${host}`, "Upgrade: websocket", "Connection: Upgrade", `Sec-WebSocket-Key: ${randomBytes(16).toString("base64")}`, "Sec-WebSocket-Version: 13", ...(protocol ? [`Sec-WebSocket-Protocol: ${protocol}`] : []), ...(origin ? [`Origin: ${origin}`] : [])];
    const client = { got: Buffer.alloc(0), open: false, over: false };
    const socket = connect(Number(port), hostname, () => socket.write(head.join("\r\n") + "\r\n\r\n"));
    const settle = () => done(client);
    client.frame = (payload, first = 0x81) => {
      const body = Buffer.from(payload), mask = Buffer.from([1, 2, 3, 4]);
      const size = body.length < 126 ? Buffer.from([0x80 | body.length]) : body.length < 65536 ? Buffer.from([0xfe, body.length >> 8, body.length & 255]) : Buffer.concat([Buffer.from([0xff, 0, 0, 0, 0]), Buffer.from([body.length >>> 24, (body.length >> 16) & 255, (body.length >> 8) & 255, body.length & 255])]);
      return Buffer.concat([Buffer.from([first]), size, mask, body.map((b, i) => b ^ mask[i & 3])]);
    };
    client.say = (text) => socket.write(client.frame(text));
    client.write = (bytes) => socket.write(bytes);
    client.end = () => socket.destroy();
    client.pending = () => socket.writableLength;
    socket.on("data", (data) => {
      client.got = Buffer.concat([client.got, data]);
      if (!client.open && client.got.includes("\r\n\r\n")) {
        client.open = client.got.toString("latin1").startsWith("HTTP/1.1 101");
        if (!read) socket.pause();
        settle();
      }
    });
    socket.on("error", () => {});
    socket.on("close", () => {
      client.over = true;
      settle();
    });
    setTimeout(settle, 10000);
  });
}

const answered = async (client, times = 400) => {
  const before = client.got.length;
  client.say("1 pose");
  for (let k = 0; k < times && client.got.length === before; ++k) await wait(25);
  return client.got.length > before;
};

// Only this machine's own page, with the token.
const first = await get(pathname);
check(first.startsWith("HTTP/1.1 200") && /content-security-policy: default-src 'none'/i.test(first), "the page is served, and loads nothing");
for (const path of ["/", "/index.html", `${pathname}../../etc/passwd`, `${pathname}%2e%2e/etc/passwd`, `/${"0".repeat(32)}/`, `${pathname.slice(0, -2)}x/`, `${pathname}page.js`])
  check(/^HTTP\/1\.1 (404|403|400)/.test(await get(path)), `${path} is refused`);
check((await get(pathname, "evil.example")).startsWith("HTTP/1.1 403"), "a foreign name that leads here is refused");
for (const wrong of [{ origin: "http://evil.example" }, { origin: null }, { origin: "null" }, { path: `/${"0".repeat(32)}/ws` }, { path: "/ws" }, { host: "evil.example" }, { protocol: null }, { protocol: "http" }, { protocol: "other" }]) {
  const client = await open(wrong);
  check(!client.open, `a WebSocket with ${JSON.stringify(wrong)} is refused`);
  client.end();
}

// A message that is too large ends the connection; so do broken frames; the server goes on.
const large = await open(), tooLarge = Buffer.from([0x03, 0xf1]); // 1009
check(large.open && (await answered(large)), "a page is answered");
large.say("1".repeat(70000));
for (let k = 0; k < 400 && !large.got.includes(tooLarge); ++k) await wait(25);
check(large.got.includes(tooLarge), "a message of 70 kB ends the connection with 1009");
for (let k = 0; k < 200; ++k) {
  const rude = await open();
  rude.write(k % 2 ? randomBytes(300) : rude.frame(randomBytes(60), 0x80 | (k % 16)));
  await wait(2);
  rude.end();
}

// A hundred connections: some are pages, the others are told why they aren't; all of them can go.
await wait(200);
const before = memory(), many = await Promise.all(Array.from({ length: 100 }, () => open()));
for (const client of many) if (!client.over) client.say("1 hello 1");
await wait(600);
const holding = (text) => many.filter((c) => c.got.includes(text)).length, pages = holding('"kind":"model"'), told = holding("16 pages are open already");
check(told === 100 - pages, `${told} of ${100 - pages} connections are told that there are 16 pages`);
check(pages >= 8 && pages <= 16, `of 100 connections ${pages} are pages`);
for (const client of many) client.end();
await wait(300);
check(memory() < before + 60000, "memory after 100 connections");

// A client that never reads: its messages wait in its own computer; memory stays, and others are served.
const deaf = await open({ read: false }), start = memory();
const piece = Buffer.concat(Array.from({ length: 200 }, () => deaf.frame("1 hello 1")));
for (let k = 0; k < 300 && deaf.pending() < 4e6; ++k) {
  deaf.write(piece);
  await wait(2);
}
await wait(500);
check(memory() < start + 20000, `memory grows by ${memory() - start} kB for a client that never reads`);
const other = await open();
check(other.open && (await answered(other)), "another page is served meanwhile");
other.end();
deaf.end();
const last = memory();
server.stop();
console.log(`${passed} passed, ${failed} failed; memory ${last} kB`);
process.exit(failed ? 1 : 0);
