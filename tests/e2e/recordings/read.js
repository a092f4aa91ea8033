// Reads recordings with the independent library @mcap/core. Prints for each FILE a line of JSON
// with its messages per topic, the last time of each, its schemas and attachments, whether it is
// complete, and for complete files the number of messages in its index.
const fs = require("node:fs");
const { McapStreamReader, McapIndexedReader } = require("@mcap/core");
const fzstd = require("fzstd");

const decompressHandlers = { zstd: (bytes, size) => fzstd.decompress(bytes, new Uint8Array(Number(size))) };

function readStream(file) {
  const seen = { topics: {}, last: {}, first: {}, schemas: [], attachments: [], notes: {}, whole: false };
  const channels = new Map();
  const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  const bytes = fs.readFileSync(file);
  reader.append(new Uint8Array(bytes.buffer, bytes.byteOffset, bytes.length));
  for (let record; (record = reader.nextRecord()); ) {
    if (record.type === "Channel") channels.set(record.id, record.topic);
    if (record.type === "Schema" && !seen.schemas.includes(record.name)) seen.schemas.push(record.name);
    if (record.type === "Attachment") seen.attachments.push(record.name);
    if (record.type === "Metadata") seen.notes[record.name] = Object.fromEntries(record.metadata);
    if (record.type === "Footer") seen.whole = true;
    if (record.type !== "Message") continue;
    const topic = channels.get(record.channelId);
    const seconds = Number(record.logTime) / 1e9;
    seen.topics[topic] = (seen.topics[topic] ?? 0) + 1;
    seen.first[topic] = Math.min(seen.first[topic] ?? Infinity, seconds);
    seen.last[topic] = Math.max(seen.last[topic] ?? 0, seconds);
  }
  return seen;
}

async function countIndexed(file) {
  const handle = await fs.promises.open(file);
  const readable = {
    size: async () => BigInt((await handle.stat()).size),
    read: async (offset, length) => {
      const buffer = new Uint8Array(Number(length));
      await handle.read(buffer, 0, Number(length), Number(offset));
      return buffer;
    },
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  let messages = 0;
  for await (const _ of reader.readMessages()) ++messages;
  await handle.close();
  if (BigInt(messages) !== reader.statistics.messageCount) throw new Error("the statistics count otherwise");
  return messages;
}

async function main() {
  for (const file of process.argv.slice(2)) {
    const seen = readStream(file);
    if (seen.whole) seen.indexed = await countIndexed(file);
    console.log(JSON.stringify({ file, ...seen }));
  }
}
main();
