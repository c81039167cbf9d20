// The view of report.html in headless Chromium: what it shows against what the program wrote, and what a page may not do.
// ISOPACH_BIN: the program. Exit code 77: skipped, for want of Chromium or of what viewer/package.json lists; with
// ISOPACH_VIEWER_TEST=required that is a failure.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {copyFileSync, existsSync, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {tmpdir} from 'node:os';
import {dirname, join} from 'node:path';
import {after, before, test} from 'node:test';
import {fileURLToPath, pathToFileURL} from 'node:url';

const require = createRequire(join(dirname(fileURLToPath(import.meta.url)), '../../viewer/package.json'));
const browserPath = [process.env.CHROMIUM, '/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(p => p && existsSync(p));
const program = process.env.ISOPACH_BIN;

function needed() {
  if (!browserPath) return 'no Chromium (scripts/setup.sh installs it)';
  try { require.resolve('playwright-core'); require.resolve('axe-core'); } catch { return 'no playwright-core (scripts/viewer --tools installs it)'; }
  return program ? '' : 'ISOPACH_BIN is not set';
}
const missing = needed();
if (missing) {
  console.log(`view_test: skipped: ${missing}`);
  process.exit(process.env.ISOPACH_VIEWER_TEST === 'required' ? 1 : 77);
}
const {chromium} = require('playwright-core');

const markup = '</script><script>window.hacked=1</script><img src=x onerror="window.hacked=1">';
const hostileFile = '<img src=x onerror=window.hacked=1>&\'.ply';
let folder, browser, exact;

const run = (...words) => execFileSync(program, [...words, '--quiet'], {cwd: folder, stdio: ['ignore', 'pipe', 'inherit']});
const report = name => pathToFileURL(join(folder, name, 'report.html')).href;

/** Opens a report; `requests` are all that it makes. */
async function opened(name, hash = '', options = {}) {
  const context = await browser.newContext({viewport: {width: 1200, height: 1000}, acceptDownloads: true, ...options});
  const page = await context.newPage(), requests = [], errors = [];
  page.on('request', r => { if (!/^(data|blob):/.test(r.url())) requests.push(r.url()); });
  page.on('pageerror', e => errors.push(e.message));
  page.on('console', m => { if (m.type() === 'error') errors.push(m.text()); });
  await page.goto(report(name) + hash);
  if (options.javaScriptEnabled !== false)
    await page.waitForFunction(() => document.documentElement.dataset.view === 'ready', null, {timeout: 180000});
  return {page, requests, errors, close: () => context.close()};
}

async function download(page, text) {
  const [file] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', {name: text}).click()]);
  return readFileSync(await file.path(), 'utf8');
}

/** difference.ply: the cells as the program wrote them, and d at a place by trying every triangle. */
function cells(path) {
  const bytes = readFileSync(path), end = bytes.indexOf('end_header\n') + 11, head = bytes.subarray(0, end).toString('latin1');
  const sizes = {double: 8, float: 4, uchar: 1, int: 4};
  const nodes = Number(/element vertex (\d+)/.exec(head)[1]), faces = Number(/element face (\d+)/.exec(head)[1]);
  const columns = [...head.matchAll(/property (double|float|uchar|int) (\w+)/g)].map(m => [m[2], m[1]]);
  let at = end;
  const vertices = [];
  for (let i = 0; i < nodes; ++i) {
    const v = {};
    for (const [name, type] of columns) {
      v[name] = type === 'double' ? bytes.readDoubleLE(at) : type === 'float' ? bytes.readFloatLE(at) : bytes.readUInt8(at);
      at += sizes[type];
    }
    vertices.push(v);
  }
  const triangles = [];
  for (let i = 0; i < faces; ++i, at += 13) triangles.push([bytes.readUInt32LE(at + 1), bytes.readUInt32LE(at + 5), bytes.readUInt32LE(at + 9)]);
  return (x, y) => {
    for (const t of triangles) {
      const [a, b, c] = t.map(v => vertices[v]);
      if (Math.max(a.x, b.x, c.x) < x || Math.min(a.x, b.x, c.x) > x || Math.max(a.y, b.y, c.y) < y || Math.min(a.y, b.y, c.y) > y) continue;
      const all = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
      const p = ((x - a.x) * (c.y - a.y) - (c.x - a.x) * (y - a.y)) / all, q = ((b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y)) / all;
      if (p < -1e-9 || q < -1e-9 || p + q > 1 + 1e-9) continue;
      return {d: a.dz + p * (b.dz - a.dz) + q * (c.dz - a.dz), zb: a.z + p * (b.z - a.z) + q * (c.z - a.z)};
    }
    return null;
  };
}

const dataOf = page => page.evaluate(() => {
  const {scenes, ...rest} = JSON.parse(document.getElementById('view-data').textContent);
  return {...rest, scenes: scenes.map(({data, ...s}) => s)};
});
const numbers = text => text.replaceAll('\u202f', '').replaceAll('\u2212', '-').match(/-?\d+(\.\d+)?/g).map(Number);
/** From above, without perspective, at a place of the terrain. */
const above = (x, y) => `#camera=${x},${y},820,${x},${y - 0.01},3820,200`;

before(async () => {
  folder = mkdtempSync(join(tmpdir(), 'isopach-view-'));
  run('simulate', 'terrain', '-o', 'scans');
  copyFileSync(join(folder, 'scans/a.ply'), join(folder, hostileFile));
  const square = [[412480, 5236450], [412680, 5236450], [412680, 5236650], [412480, 5236650], [412480, 5236450]];
  writeFileSync(join(folder, 'areas.geojson'), JSON.stringify({type: 'FeatureCollection', features: [
    {type: 'Feature', properties: {name: markup}, geometry: {type: 'Polygon', coordinates: [square]}}]}));
  run('compare', hostileFile, 'scans/b.ply', '-o', 'plain', '--sigma1', '0.02', '--sigma2', '0.03', '--budget', 'areas.geojson');
  run('compare', hostileFile, 'scans/b.ply', '-o', 'thin', '--report-vertices', '20000', '--title', markup, '--no-points', '--no-cells');
  run('compare', 'scans/a.ply', 'scans/b.ply', '-o', 'none', '--report-vertices', '0', '--no-points', '--no-cells', '--no-map');
  run('simulate', 'face', '-o', 'face', '--points', '8000');
  run('match', 'face/b.ply', 'face/a.ply', '-o', 'match');
  run('distance', hostileFile, 'scans/b.ply', '-o', 'distance', '--measure', 'm3c2,c2s', '--normal-scale', '20', '--projection-scale', '15', '--max-depth', '20');
  run('simulate', 'chewing', '-o', 'chewing', '--points', '6000');
  run('sequence', 'chewing', '-o', 'sequence');
  run('info', hostileFile, '-o', 'info');
  run('simulate', 'combine', '-o', 'parts', '--points', '9000', '--seed', '3');
  run('combine', 'parts/face.ply', 'parts/jaw.ply', '--reference', 'parts/reference.ply', '-o', 'combine');
  exact = cells(join(folder, 'plain/difference.ply'));
  browser = await chromium.launch({executablePath: browserPath, args: ['--no-sandbox', '--enable-unsafe-swiftshader']});
});
after(async () => {
  await browser?.close();
  rmSync(folder, {recursive: true, force: true});
});

test('a report of the default size opens from disk, asks for nothing, and shows something', async () => {
  assert.ok(statSync(join(folder, 'plain/report.html')).size <= 5e6);
  const {page, requests, errors, close} = await opened('plain');
  const colours = await page.evaluate(() => {
    const source = document.querySelector('#view canvas'), copy = document.createElement('canvas');
    copy.width = source.width; copy.height = source.height;
    const g = copy.getContext('2d');
    g.drawImage(source, 0, 0);
    return new Set(new Uint32Array(g.getImageData(0, 0, copy.width, copy.height).data.buffer)).size;
  });
  assert.ok(colours > 500, `${colours} colours`);
  await page.mouse.move(400, 400);
  await page.waitForTimeout(500);
  assert.equal(requests.length, 1, requests.join('\n'));
  assert.deepEqual(errors, []);
  await close();
});

test('a value is read with coordinates to 1 mm and d to a thousandth of its range', async () => {
  for (const [x, y] of [[412520.25, 5236543.5], [412333.125, 5236701.75], [412610, 5236500]]) {
    const {page, close} = await opened('plain', above(x, y));
    const data = await dataOf(page), scene = data.scenes[0], range = scene.d.step * 65535;
    const canvas = page.locator('#view canvas'), box = await canvas.boundingBox();
    const read = async () => numbers((await page.locator('.v-read').innerText()).replace(/[a-z] of [AB]/g, ''));
    await canvas.click({position: {x: box.width / 2, y: box.height / 2}});
    const clicked = await read();  // places of a mouse are known to 1/64 of a pixel, which is 9 mm here
    assert.ok(Math.hypot(clicked[0] - x, clicked[1] - y) < 0.05, String(clicked));
    await canvas.press('Enter');  // at the middle
    const [px, py, za, zb, d] = await read();
    const truth = exact(px, py);
    assert.ok(Math.abs(px - x) < 1e-3 && Math.abs(py - y) < 1e-3, `${px} ${py}`);
    assert.ok(Math.abs(d - truth.d) < 1e-3 * range, `d ${d}, exact ${truth.d}`);
    assert.ok(Math.abs(d - truth.d) <= scene.error.d + 1e-3, 'within the stated bound');
    assert.ok(Math.abs(zb - za - d) < 2e-3 && Math.abs(zb - truth.zb) < 2 * (scene.error.d + scene.error.z) + 1e-3);
    await close();
  }
});

test('a section is that of the exact surfaces within the stated bound', async () => {
  const {page, close} = await opened('plain', '#section=412320_5236310,412530_5236560,412700_5236810!');
  const bound = (await dataOf(page)).scenes[0].error.d;
  assert.equal(await page.locator('.v-below svg').count(), 1);
  const [head, ...rows] = (await download(page, 'Values (CSV)')).trim().split('\n');
  assert.equal(head, 's,x,y,z_a,z_b,d,lod');
  assert.ok(rows.length > 300);
  let last = -1;
  for (const [i, row] of rows.entries()) {
    const [s, x, y, za, zb, d] = row.split(',').map(Number);
    assert.ok(s > last, row);
    last = s;
    assert.ok(Math.abs(zb - za - d) < 1e-6);
    if (i % 7 === 0) assert.ok(Math.abs(d - exact(x, y).d) <= bound, `${row}: ${exact(x, y).d}`);
  }
  assert.match(await download(page, 'Drawing (SVG)'), /^<svg[^]*<path[^]*<\/svg>$/);
  await close();
});

test('volumes over an area are those of the program within the stated bound', async () => {
  for (const name of ['plain', 'thin']) {
    const {page, close} = await opened(name, '#polygon=412480_5236450,412690_5236470,412600_5236560,412660_5236690,412450_5236620!');
    const shown = await page.locator('.v-below table').evaluate(t => ({...t.dataset}));
    writeFileSync(join(folder, 'area.geojson'), await download(page, 'This area (GeoJSON)'));
    const result = JSON.parse(run('compare', hostileFile, 'scans/b.ply', '--budget', 'area.geojson', '--json', '-').toString());
    const [row] = result.budget;
    assert.equal(row.name, 'area');
    assert.ok(Math.abs(shown.area - row.area) < 1e-3 * row.area);
    for (const part of ['above', 'below']) assert.ok(Math.abs(shown[part] - row[part]) <= Number(shown.bound), `${part}: ${shown[part]}, exact ${row[part]}`);
    await close();
  }
});

test('clicks draw a section; keys change the surface, read a value and copy it', async () => {
  const {page, errors, close} = await opened('plain', above(412500, 5236500), {permissions: ['clipboard-read', 'clipboard-write']});
  const canvas = page.locator('#view canvas');
  await page.getByRole('radio', {name: 'section'}).check();
  for (const [x, y] of [[200, 200], [420, 330]]) await canvas.click({position: {x, y}});
  await page.getByRole('button', {name: 'Finish'}).click();
  assert.equal(await page.locator('.v-below svg').count(), 1);
  await page.getByRole('radio', {name: 'value'}).check();
  assert.equal(await page.locator('.v-below svg').count(), 0);
  await canvas.focus();
  assert.match(await page.locator('.v-tag').innerText(), /^B/);
  await page.keyboard.press('Space');
  assert.match(await page.locator('.v-tag').innerText(), /^A/);
  await page.keyboard.press('Enter');
  assert.match(await page.locator('.v-read').innerText(), /difference/);
  await page.keyboard.press('c');
  await page.waitForSelector('.v-copied');
  const values = (await page.evaluate(() => navigator.clipboard.readText())).split('\t').map(Number);
  assert.equal(values.length, 6);
  assert.ok(Math.abs(values[0] - 412500) < 0.01 && Math.abs(values[1] - 5236500) < 0.01, String(values));
  assert.deepEqual(errors, []);
  await close();
});

test('limits are dragged on the histogram, and the address holds what is seen', async () => {
  const {page, close} = await opened('plain');
  const box = await page.locator('.v-histogram').boundingBox();
  await page.mouse.move(box.x + box.width - 9, box.y + 30);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.75, box.y + 30, {steps: 4});
  await page.mouse.up();
  const limits = async of => [await of.getByLabel('Lower limit').inputValue(), await of.getByLabel('Upper limit').inputValue()].map(Number);
  const [low, high] = await limits(page);
  assert.ok(high > 5 && high < 14 && low === -high, `${low} ${high}`);
  await page.getByLabel('Palette').selectOption('spectrum');
  await page.getByRole('radio', {name: 'both'}).check();
  await page.waitForFunction(() => location.hash.includes('show=both'));
  const hash = new URL(page.url()).hash;
  await close();
  const again = await opened('plain', hash);
  assert.deepEqual(await limits(again.page), [low, high]);
  assert.equal(await again.page.getByLabel('Palette').inputValue(), 'spectrum');
  assert.match(await again.page.locator('.v-tag').innerText(), /A \| B/);
  await again.close();
});

test('names are text, whatever they are', async () => {
  for (const name of ['plain', 'thin']) {
    const {page, errors, close} = await opened(name);
    assert.equal(await page.evaluate(() => window.hacked), undefined);
    assert.deepEqual(errors, []);
    const text = await page.locator('body').evaluate(b => b.textContent);
    assert.ok(text.includes(hostileFile));
    if (name === 'plain') {
      await page.locator('summary', {hasText: 'Go to'}).click();
      await page.locator('.v-list button').first().click();
      assert.ok((await page.locator('.v-list').innerText()).includes(markup));
    }
    await close();
  }
});

test('without scripts the page is complete', async () => {
  const {page, close} = await opened('plain', '', {javaScriptEnabled: false});
  const text = await page.locator('main').innerText();
  for (const words of ['gained', 'The numbers', 'How the area is spread over d', 'Options in force']) assert.ok(text.includes(words), words);
  const picture = page.locator('figure img').first();
  assert.ok(await picture.isVisible());
  assert.equal(await page.locator('#view').innerText(), '');
  await close();
});

test('a report without a view has no script', () => {
  const text = readFileSync(join(folder, 'none/report.html'), 'utf8');
  assert.ok(!text.includes('<script>') && !text.includes('script-src'));
});

test('printed, the page has the view as it was turned', async () => {
  const {page, close} = await opened('plain');
  await page.pdf();
  await page.evaluate(() => window.dispatchEvent(new Event('beforeprint')));
  await page.emulateMedia({media: 'print'});
  assert.ok(await page.locator('.v-print').isVisible());
  assert.ok(!(await page.locator('.v-stage').isVisible()) && !(await page.locator('.v-panel').isVisible()));
  assert.ok(await page.locator('.v-print').evaluate(i => i.naturalWidth) >= 1600);
  await close();
});

test('a matching shows before and after in one place and one scale', async () => {
  const {page, errors, close} = await opened('match');
  const tag = page.locator('.v-tag'), input = page.getByLabel('Upper limit');
  assert.match(await tag.innerText(), /^after/);
  const limit = await input.inputValue();
  const camera = () => new URL(page.url()).hash.match(/camera=([^&]*)/)[1];
  await page.waitForTimeout(600);
  const seen = camera();
  await page.getByRole('radio', {name: 'before'}).check();
  await page.waitForTimeout(600);
  assert.match(await tag.innerText(), /^before/);
  assert.equal(await input.inputValue(), limit);
  assert.equal(camera(), seen);
  assert.deepEqual(errors, []);
  await close();
});

test('nothing serious for people who cannot see well or use no mouse', async () => {
  for (const options of [{}, {colorScheme: 'dark'}, {viewport: {width: 390, height: 844}, hasTouch: true}]) {
    const {page, close} = await opened('plain', '#section=412320_5236310,412700_5236810!', {bypassCSP: true, ...options});
    await page.evaluate(() => { for (const d of document.querySelectorAll('.v-panel details')) d.open = true; });
    await page.addScriptTag({path: require.resolve('axe-core')});
    const {violations} = await page.evaluate(() => window.axe.run());
    const serious = violations.filter(v => v.impact === 'serious' || v.impact === 'critical');
    assert.deepEqual(serious.map(v => [v.id, v.nodes.map(n => n.html.slice(0, 160))]), []);
    assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), 'no scrolling sideways');
    await close();
  }
});

const spaces = ['distance', 'sequence', 'combine', 'info'];
const coloursOf = page => page.evaluate(() => {
  const source = document.querySelector('.v-stage canvas'), copy = document.createElement('canvas');
  copy.width = source.width; copy.height = source.height;
  const g = copy.getContext('2d');
  g.drawImage(source, 0, 0);
  const bytes = g.getImageData(0, 0, copy.width, copy.height).data;
  let sum = 0;
  for (let i = 0; i < bytes.length; i += 4) sum = (sum * 31 + bytes[i] + 3 * bytes[i + 1] + 7 * bytes[i + 2]) % 1000000007;
  return {count: new Set(new Uint32Array(bytes.buffer)).size, sum};
});

test('points in space: pages of distance, sequence and combine ask for nothing, show something, and read places', async () => {
  for (const name of spaces) {
    assert.ok(statSync(join(folder, name, 'report.html')).size <= 5e6, name);
    const {page, requests, errors, close} = await opened(name);
    assert.ok((await coloursOf(page)).count > 100, name);
    const canvas = page.locator('.v-stage canvas');
    let read = [];
    const box = await canvas.boundingBox();
    for (const [u, v] of [[0.5, 0.5], [0.45, 0.55], [0.55, 0.45], [0.4, 0.5], [0.6, 0.6], [0.5, 0.35]]) {
      await canvas.click({position: {x: u * box.width, y: v * box.height}});
      if ((await page.locator('.v-read b').count()) > 0) { read = await page.locator('.v-read b').allInnerTexts(); break; }
    }
    assert.ok(read.length >= 4, `${name}: ${read}`);
    const {columns} = await page.evaluate(() => JSON.parse(document.getElementById('view-data').textContent));
    ['x', 'y', 'z'].forEach((axis, i) => {
      const {low, step} = columns.find(c => c.name === axis), at = numbers(read[i])[0];
      assert.ok(at >= low - 2 * step && at <= low + 1048577 * step, `${name} ${axis} ${at}`);
    });
    assert.equal(requests.length, 1, requests.join('\n'));
    assert.deepEqual(errors, []);
    assert.equal(await page.evaluate(() => window.hacked), undefined);
    if (name === 'distance') assert.ok((await page.locator('body').evaluate(b => b.textContent)).includes(hostileFile));
    await close();
  }
});

test('a sequence plays, stops and steps, each frame with its motion', async () => {
  const {page, errors, close} = await opened('sequence');
  const slider = page.getByLabel('Frame', {exact: true}), tag = page.locator('.v-tag');
  const first = await coloursOf(page), label = await tag.innerText();
  await page.getByRole('button', {name: 'Play'}).click();
  await page.waitForFunction(() => Number(document.querySelector('.v-play input').value) > 2);
  await page.getByRole('button', {name: 'Pause'}).click();
  await slider.fill('9');
  assert.notEqual(await tag.innerText(), label);
  await page.waitForTimeout(300);
  assert.notEqual((await coloursOf(page)).sum, first.sum);
  await page.locator('.v-stage canvas').press(',');
  assert.equal(await slider.inputValue(), '8');
  await page.locator('.v-stage canvas').press('.');
  await page.waitForTimeout(600);
  assert.match(page.url(), /frame=9/);
  const {frames} = await page.evaluate(() => JSON.parse(document.getElementById('view-data').textContent));
  const result = JSON.parse(readFileSync(join(folder, 'sequence/result.json'), 'utf8'));
  const used = result.frames.filter(f => f.skipped === null);
  assert.equal(frames.length, used.length);
  frames.forEach((f, i) => assert.deepEqual(f.matrix, used[i].motion.slice(0, 3).flat()));
  assert.deepEqual(errors, []);
  await close();
});

test('pages of points in space are complete without scripts, printed with the view, and serve everybody', async () => {
  for (const name of spaces) {
    const bare = await opened(name, '', {javaScriptEnabled: false});
    assert.ok(await bare.page.locator('figure img, figure svg, main svg').first().isVisible(), name);
    assert.equal(await bare.page.locator('#view').innerText(), '');
    await bare.close();
    for (const options of [{}, {colorScheme: 'dark'}, {viewport: {width: 390, height: 844}, hasTouch: true}]) {
      const {page, close} = await opened(name, '', {bypassCSP: true, ...options});
      await page.evaluate(() => { for (const d of document.querySelectorAll('.v-panel details')) d.open = true; });
      await page.addScriptTag({path: require.resolve('axe-core')});
      const {violations} = await page.evaluate(() => window.axe.run());
      const serious = violations.filter(v => v.impact === 'serious' || v.impact === 'critical');
      assert.deepEqual(serious.map(v => [v.id, v.nodes.map(n => n.html.slice(0, 160))]), [], name);
      assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${name}: no scrolling sideways`);
      await page.evaluate(() => window.dispatchEvent(new Event('beforeprint')));
      await page.emulateMedia({media: 'print'});
      assert.ok(await page.locator('.v-print').isVisible() && !(await page.locator('.v-stage').isVisible()));
      await close();
    }
  }
});
