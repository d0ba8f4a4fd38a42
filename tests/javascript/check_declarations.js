// check_declarations.js DECLARATIONS PROGRAM TYPES: type checks both, and not the declarations of others, which takes longer.
'use strict';

const ts = require('typescript');

const [, , declarations, program, types] = process.argv;
const compiled = ts.createProgram([declarations, program], {
  noEmit: true, strict: true, target: ts.ScriptTarget.ES2022, lib: ['lib.es2022.d.ts'], module: ts.ModuleKind.CommonJS,
  moduleResolution: ts.ModuleResolutionKind.Node10, esModuleInterop: true, typeRoots: [types], baseUrl: '.',
  paths: { hgros: [declarations] },
});
const faults = [...compiled.getOptionsDiagnostics(), ...compiled.getGlobalDiagnostics(), ...compiled.getSyntacticDiagnostics(),
  ...[declarations, program].flatMap((file) => compiled.getSemanticDiagnostics(compiled.getSourceFile(file)))];
for (const { file, start, messageText } of faults) {
  const line = file ? file.getLineAndCharacterOfPosition(start).line + 1 : '';
  console.error(`${file?.fileName}:${line}: ${ts.flattenDiagnosticMessageText(messageText, '\n')}`);
}
process.exitCode = faults.length ? 1 : 0;
