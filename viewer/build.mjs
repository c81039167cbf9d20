// Bundles src/main.ts to bundle/viewer.js: one script, ASCII, with the licences of what is in it. `scripts/viewer` runs it.
import {readFileSync, writeFileSync, mkdirSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {build} from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));
const output = process.argv[2] ?? join(here, 'bundle', 'viewer.js');

const licence = name => {
  const folder = join(here, 'node_modules', name);
  const {version} = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8'));
  return `${name} ${version}\n\n${readFileSync(join(folder, 'LICENSE'), 'utf8').trim()}`;
};
const notice = ['The view of isopach, MIT License. It contains:', licence('three'), licence('three-mesh-bvh')]
    .join('\n\n').replaceAll('\r', '').replace(/[^\x00-\x7f]/g, c => `(U+${c.codePointAt(0).toString(16)})`)
    .replaceAll('*/', '* /');

const result = await build({
  entryPoints: [join(here, 'src', 'main.ts')],
  bundle: true, minify: true, format: 'iife', target: 'es2022', charset: 'ascii', legalComments: 'none',
  absWorkingDir: here, write: false,
});
const text = `/*!\n${notice}\n*/\n${result.outputFiles[0].text}`;
// It stands in a page as the text of a script element, and its digest in the page's policy.
for (const forbidden of ['<!--', '<script', '</script', '\r', ')isopach"'])
  if (text.includes(forbidden)) throw new Error(`the bundle has ${JSON.stringify(forbidden)}`);
mkdirSync(dirname(output), {recursive: true});
writeFileSync(output, text);
console.log(`${output}: ${text.length} bytes`);
