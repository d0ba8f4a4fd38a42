/// <reference types="node" />

/** What a channel carries: the name of a type of the library, a type of protobufjs, or a Schema. */
export type MessageType = string | Schema | ProtobufType;

/** A reflected type of protobufjs, such as `root.lookupType('my.Type')`. */
export interface ProtobufType {
  readonly fullName: string;
  readonly fieldsArray: unknown[];
  encode(message: any, writer?: any): any;
  decode(reader: any, length?: number): any;
  fromObject(object: { [name: string]: any }): any;
}

export type Code =
  | 'HGROS_INVALID_ARGUMENT' | 'HGROS_ERROR' | 'HGROS_TYPE_MISMATCH' | 'HGROS_CONFIG_ERROR' | 'HGROS_CLOSED'
  | 'HGROS_FULL' | 'HGROS_TIMED_OUT' | 'HGROS_WOULD_DEADLOCK' | 'HGROS_TOO_LARGE' | 'HGROS_NO_MEMORY'
  | 'HGROS_NOT_FOUND' | 'HGROS_REFUSED' | 'HGROS_NO_SERVER' | 'HGROS_HANDLER_FAILED' | 'HGROS_SERVER_GONE'
  | 'HGROS_CANCELLED' | 'HGROS_NOT_WRITABLE' | 'HGROS_UNKNOWN_FRAME' | 'HGROS_NOT_CONNECTED' | 'HGROS_TOO_OLD'
  | 'HGROS_TOO_NEW';

/** What the library refuses. The message says what is wrong, where, and how to mend it. */
export class HgrosError extends Error {
  constructor(code: Code, sentence: string);
  readonly code: Code;
}

export type Encoding = 'none' | 'protobuf' | 'custom' | 'plain';
export type Level = 'debug' | 'info' | 'warning' | 'error';

/** The type of messages. Never changes. */
export class Schema {
  /** A type of your own: its messages are bytes. The default encoding is 'custom'. */
  constructor(typeName: string, options?: {
    encoding?: Encoding;
    /** 0n, the default: types are compared by name and encoding alone. */
    fingerprint?: bigint;
    /** For protobuf: a google.protobuf.FileDescriptorSet. */
    descriptorSet?: Uint8Array;
  });
  /** The schema of a type that comes with the library. */
  static known(typeName: string): Schema;
  readonly typeName: string;
  readonly encoding: Encoding;
  readonly fingerprint: bigint;
  readonly descriptorSet: Buffer | undefined;
}

export interface SessionOptions {
  /** For logs and other sessions' tables. */
  name?: string;
  /** Gets the log instead of standard error. */
  log?: (level: Level, line: string) => void;
}

/** In milliseconds. Without one, a wait has no end. */
export interface Timeout {
  timeout?: number;
}

export interface MessageInfo {
  /** From another session. */
  remote: boolean;
  /** The id of the sender's session. */
  publisher: bigint;
  /** Grows with each start of the sender. */
  incarnation: bigint;
  /** Counts the sender's messages on the channel. */
  sequence: bigint;
  /** Names the message in all processes. */
  key: bigint;
  /** As process.hrtime.bigint(), when published or received from another host. */
  publishMonotonic: bigint;
  /** The sender's wall clock in ns; 0n for messages of the same session. */
  publishTime: bigint;
}

export interface Received<T = any> {
  /** Decoded; a Buffer if the type is raw. */
  readonly message: T;
  /** The bytes, which nobody may write. */
  readonly data: Buffer;
  readonly info: MessageInfo;
  /** The type that came with the channel; undefined if its publisher, a plain program, named none. */
  readonly schema: Schema | undefined;
  /** Gives the memory of a large message back now; its bytes are empty then. */
  close(): void;
}

export interface SubscribeOptions {
  /** For logs, tables and configuration. */
  name?: string;
  /** Newest messages that may wait, older ones are dropped and counted; 16 is the default. */
  keepLast?: number;
  /** Lossless, with room for this many. */
  keepAll?: number;
  /** For keepAll: also at most about this many bytes. */
  keepAllBytes?: number;
}

export interface Subscription<T = any> extends AsyncIterableIterator<Received<T>> {
  /** Waits for the oldest message. */
  take(options?: Timeout): Promise<Received<T>>;
  stats(): { received: number; dropped: number; taken: number; queued: number; mismatched: number };
  close(): void;
}

export interface Publisher<T = any> {
  /** Never waits. Throws HGROS_FULL if a lossless subscriber has no room: nobody got it. */
  publish(message: T): void;
  /** Waits until every lossless subscriber has room. */
  publishWait(message: T, options?: Timeout): Promise<void>;
  /** Memory for a message of `size` bytes, to fill and publish in place. */
  loan(size: number): Loan;
  close(): void;
}

export interface Loan {
  /** The bytes to fill; undefined once they are published. Views of it are empty then. */
  readonly data: Buffer | undefined;
  /** Throws HGROS_FULL if there is no room, or while messages of publishWait() wait. Then the loan is as it was. */
  publish(): void;
  /** After the messages that wait already. */
  publishWait(options?: Timeout): Promise<void>;
  /** Gives back a loan that was not published. Otherwise the garbage collector does. */
  close(): void;
}

export interface Service {
  /** Waits for the running handler. */
  close(): Promise<void>;
}

export interface Watch {
  close(): void;
}

export type ParamValue = boolean | number | bigint | string | ParamValue[] | { [name: string]: ParamValue };

export interface ParamOptions {
  /** Of a number: 'number' is the default. */
  kind?: 'bool' | 'integer' | 'number' | 'text' | 'numbers';
  description?: string;
  unit?: string;
  readOnly?: boolean;
  least?: number | bigint;
  most?: number | bigint;
  choices?: string[];
}

/** The parameters of this program. A path is written like `slam.matcher.gains[2]`. */
export interface Params {
  declare(path: string, fallback: ParamValue, options?: ParamOptions): void;
  bool(path: string): boolean;
  /** A bigint beyond Number.MAX_SAFE_INTEGER. */
  integer(path: string): number | bigint;
  number(path: string): number;
  text(path: string): string;
  /** Any value; an empty path is the whole tree. */
  yaml(path: string): string;
  set(path: string, value: ParamValue): void;
  setYaml(path: string, yaml: string): void;
  remove(path: string): void;
  /** Writes what was set at run time into the files. */
  save(): void;
  watch(path: string, changed: (path: string, yaml: string | undefined) => void): Watch;
  close(): Promise<void>;
}

/** The parameters of another session, which each function asks. */
export interface RemoteParams {
  bool(path: string): Promise<boolean>;
  integer(path: string): Promise<number | bigint>;
  number(path: string): Promise<number>;
  text(path: string): Promise<string>;
  yaml(path: string): Promise<string>;
  set(path: string, value: ParamValue): Promise<void>;
  setYaml(path: string, yaml: string): Promise<void>;
  remove(path: string): Promise<void>;
  watch(path: string, changed: (path: string, yaml: string | undefined) => void): Watch;
  close(): Promise<void>;
}

/** p_target = rotation * p_source + translation. */
export interface Transform {
  /** x, y, z in meters. */
  translation: number[];
  /** A unit quaternion: x, y, z, w. */
  rotation: number[];
  /** In ns: the time at which it holds; 0n if only static transforms connect the frames. */
  stamp: bigint;
}

export interface Transforms {
  set(parent: string, child: string, transform: Partial<Transform>): void;
  setStatic(parent: string, child: string, transform: Partial<Transform>): void;
  /** T_target_source at a time in ns, or at the latest one. */
  lookup(target: string, source: string, time?: bigint): Transform;
  wait(target: string, source: string, time: bigint, options?: Timeout): Promise<Transform>;
  close(): Promise<void>;
}

export interface Peer {
  id: bigint;
  process: string;
  host: string;
  pid: number;
  transport: string;
  why: string;
}

export interface PeerEvent {
  /** 'unknown': something that only a newer library has. */
  event: 'came' | 'gone' | 'typeMismatch' | 'servedTwice' | 'unknown';
  peer: Peer;
  channel: string;
  reason: string;
}

export interface Channel {
  name: string;
  typeName: string;
  fingerprint: bigint;
  encoding: Encoding;
  publishers: number;
  subscribers: number;
}

/** One participant of the hypergraph. */
export class Session {
  private constructor();
  readonly id: bigint;
  readonly name: string;
  /** The number of exceptions of callbacks. */
  readonly failures: number;
  /** The time of the session's clock in ns. */
  now(): bigint;
  log(level: Level, line: string): void;
  setLogLevel(level: Level): void;
  advertise<T = any>(channel: string, type: MessageType, options?: { latched?: number }): Publisher<T>;
  subscribe<T = any>(channel: string, type?: MessageType | null, options?: SubscribeOptions,
    callback?: (received: Received<T>) => void | Promise<void>): Subscription<T>;
  waitForSubscribers(channel: string, count?: number, options?: Timeout): Promise<void>;
  waitForPublishers(channel: string, count?: number, options?: Timeout): Promise<void>;
  serve<Q = any, R = any>(name: string, requestType: MessageType, replyType: MessageType,
    handler: (request: Q) => R | Promise<R>, options?: { mostWaiting?: number }): Service;
  call<Q = any, R = any>(name: string, requestType: MessageType, replyType: MessageType, request: Q,
    options?: Timeout & { signal?: AbortSignal }): Promise<R>;
  params(...files: string[]): Params;
  paramsOf(name: string, options?: Timeout): RemoteParams;
  transforms(): Transforms;
  peers(): Peer[];
  channels(): Channel[];
  watchPeers(happened: (event: PeerEvent) => void): Watch;
  /** Ends all that was made from the session, and says goodbye to the other sessions. */
  close(): Promise<void>;
}

/** Opens a session with YAML text. Without any, it finds the sessions of this user on this host. */
export function open(yaml?: string, options?: SessionOptions): Session;
/** Opens a session with configuration files, which are merged. */
export function openFiles(files: string[], options?: SessionOptions): Session;
/** A type that comes with the library, such as 'foxglove.Log'. */
export function type(typeName: string): any;
/** The number of messages of this process whose memory is not given back yet. */
export function leases(): number;
export const version: string;

declare const hgros: {
  open: typeof open;
  openFiles: typeof openFiles;
  type: typeof type;
  Session: typeof Session;
  Schema: typeof Schema;
  HgrosError: typeof HgrosError;
  leases: typeof leases;
  version: string;
  /** protobufjs, whose types this package makes. */
  readonly protobuf: any;
};
export default hgros;
