// node mcap_core.mjs write|read FOLDER
// Writes files with all options of @mcap/core, or reads files with it, and prints what is in them.
import { McapIndexedReader, McapStreamReader, McapWriter } from "@mcap/core";
import { loadDecompressHandlers } from "@mcap/support";
import zstd from "@foxglove/wasm-zstd";
import fs from "node:fs";
import path from "node:path";

const [mode, folder] = process.argv.slice(2);
const flags = ["useChunks", "useMessageIndex", "useChunkIndex", "useAttachmentIndex", "useMetadataIndex", "useStatistics",
  "repeatSchemas", "repeatChannels", "useSummaryOffsets"];

class Output {
  constructor(name) { this.descriptor = fs.openSync(name, "wx"); this.size = 0n; }
  position() { return this.size; }
  async write(bytes) { fs.writeSync(this.descriptor, bytes); this.size += BigInt(bytes.byteLength); }
}

async function write() {
  await zstd.isLoaded;
  for (let options = 0; options < 2 << flags.length; ++options) {
    const chosen = { writable: new Output(path.join(folder, `${options}.mcap`)), chunkSize: 500 };
    flags.forEach((flag, i) => { chosen[flag] = ((options >> i) & 1) !== 0; });
    if (options >> flags.length) {
      chosen.compressChunk = (data) => ({ compression: "zstd", compressedData: zstd.compress(data) });
    }
    const writer = new McapWriter(chosen);
    await writer.start({ profile: "", library: "" });
    const encoder = new TextEncoder();
    const schemaId = await writer.registerSchema({ name: "Example", encoding: "jsonschema", data: encoder.encode("{}") });
    const channels = [
      await writer.registerChannel({ topic: "with schema", messageEncoding: "json", schemaId, metadata: new Map([["key", "value"]]) }),
      await writer.registerChannel({ topic: "without", messageEncoding: "text", schemaId: 0, metadata: new Map() }),
    ];
    for (let i = 0; i < 20; ++i) {
      await writer.addMessage({ channelId: channels[i % 2], sequence: i, logTime: BigInt(100 + (i * 37) % 20),
        publishTime: BigInt(i), data: encoder.encode(`${options}${"x".repeat(i * 7)}`) });
    }
    await writer.addAttachment({ logTime: 7n, createTime: 8n, name: "name", mediaType: "text/plain", data: encoder.encode("attached") });
    await writer.addMetadata({ name: "about", metadata: new Map([["robot", "r2"]]) });
    await writer.end();
    fs.closeSync(chosen.writable.descriptor);
  }
}

async function recordsOf(bytes, decompressHandlers) {
  const found = { schemas: new Map(), channels: new Map(), messages: [], attachments: [], metadata: [] };
  const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  reader.append(bytes);
  for (let record; (record = reader.nextRecord()); ) {
    if (record.type === "Schema") found.schemas.set(record.id, record);
    if (record.type === "Channel") found.channels.set(record.id, record);
    if (record.type === "Message") found.messages.push(record);
    if (record.type === "Attachment") found.attachments.push(record);
    if (record.type === "Metadata") found.metadata.push(record);
  }
  if (!reader.done()) throw new Error("the file does not end as it should");
  found.messages.sort((a, b) => Number(a.logTime - b.logTime));
  return found;
}

// With the indexes, if the file has all of them: the same messages.
async function checkIndexes(bytes, decompressHandlers, found) {
  const readable = { size: async () => BigInt(bytes.length),
    read: async (offset, size) => bytes.subarray(Number(offset), Number(offset + size)) };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  if (reader.chunkIndexes.length === 0 || reader.channelsById.size === 0 || reader.schemasById.size === 0) return;
  if (reader.chunkIndexes.some((index) => index.messageIndexOffsets.size === 0)) return;
  const sequences = [];
  for await (const message of reader.readMessages()) sequences.push(message.sequence);
  if (sequences.join() !== found.messages.map((message) => message.sequence).join()) throw new Error("the indexes are wrong");
}

async function read() {
  const handlers = await loadDecompressHandlers();
  const decoder = new TextDecoder();
  for (const name of fs.readdirSync(folder).sort()) {
    const bytes = fs.readFileSync(path.join(folder, name));
    const found = await recordsOf(bytes, handlers);
    try {
      await checkIndexes(bytes, handlers, found);
    } catch (error) {
      if (!/not indexed/.test(error.message)) throw new Error(`${name}: ${error.message}`);
    }
    console.log(name);
    for (const m of found.messages) {
      const channel = found.channels.get(m.channelId);
      const schema = channel.schemaId === 0 ? "-" : found.schemas.get(channel.schemaId).name;
      console.log(`${channel.topic} ${channel.messageEncoding} ${channel.metadata.size} ${schema} ${m.sequence} ${m.logTime} ` +
        `${m.publishTime} ${decoder.decode(m.data)}`);
    }
    for (const a of found.attachments) console.log(`${a.name} ${a.mediaType} ${a.logTime} ${a.createTime} ${decoder.decode(a.data)}`);
    for (const m of found.metadata) m.metadata.forEach((value, key) => console.log(`${m.name} ${key} ${value}`));
  }
}

await (mode === "write" ? write() : read());
