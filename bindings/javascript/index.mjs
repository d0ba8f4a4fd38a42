import hgros from './index.js';

export const { open, openFiles, type, Session, Schema, HgrosError, leases, version } = hgros;
export default hgros;
