/* The page of measurements. data: {files: [{path, bench: docs/bench.schema.json}]}
 *
 * Cells of one scene, setting and file that differ in resolution alone form a series: a line of a chart. A setting
 * names only options that differ between cells. Each scene has a colour, each setting a mark, each file a dash.
 * SPDX-License-Identifier: GPL-3.0-or-later */

/* cells and their series ------------------------------------------------------------------------------------------------------- */

/* The same text for equal values, in any order of keys. */
const canonical = (value) => JSON.stringify(value, (_, v) =>
    v && typeof v === "object" && !Array.isArray(v) ? Object.fromEntries(Object.entries(v).sort()) : v);
const same = (a, b) => canonical(a) === canonical(b);
const word = (value) => typeof value === "string" ? value : JSON.stringify(value);

/* Files of the same name are distinguished by their paths, or else by a number. */
const files = data.files.map(({ path, bench }, n) => {
    const others = data.files.filter((f) => base_name(f.path) === base_name(path));
    const before = data.files.slice(0, n).filter((f) => f.path === path).length;
    return { bench, label: clean(before ? `${path} (${before + 1})` : others.length > 1 ? path : base_name(path)) };
});
const cells = files.flatMap(({ bench }, file) => bench.cells.map((cell) => (
    { ...cell, file, side: cell.options.resolution_px, options: { skinned: "exclude", ...cell.options } })));

/* If a scene occurs with several first lights or several suns, its name includes them. */
function scene_label(cell) {
    const others = cells.filter((c) => c.scene === cell.scene), sun = cell.options.sun;
    const several = others.some((c) => c.light !== cell.light || (sun && c.options.sun && !same(c.options.sun, sun)));
    return clean(several ? `${cell.scene}, ${cell.light}${sun ? ` ${word(sun)}` : ""}` : cell.scene);
}

/* Options of one coding only: their absence in the other is no difference. */
const dag_alone = ["rule", "reuse", "compress", "stop"], blocks_alone = ["pack"];
const is_of_one_coding = (name) => dag_alone.includes(name) || blocks_alone.includes(name);
const has_none = (options, name) => (options.coding === "blocks" ? dag_alone : blocks_alone).includes(name);

/* "rule shadow, stop insert": options that differ from those of `base`, without resolution and sun. */
function differences(given, base) {
    const told = (name) => name !== "resolution_px" && name !== "sun" && !(is_of_one_coding(name) && given.coding !== base.coding);
    const named = (o) => Object.keys(o).filter(told);
    return clean([...named(given).filter((name) => !same(given[name], base[name])).map((name) => `${name} ${word(given[name])}`),
        ...named(base).filter((name) => !(name in given)).map((name) => `no ${name}`)].join(", "));
}

const first = cells[0].options;
const is_agreed = ([name, value]) => cells.every((c) => same(c.options[name], value) || has_none(c.options, name));
const agreed = Object.fromEntries(Object.entries(first).filter(is_agreed));
const base = differences(first, agreed);
const number_in = (names, name) => names.includes(name) ? names.indexOf(name) : names.push(name) - 1;
const scenes = [], settings = [], series = [];
for (const cell of cells) {
    cell.scene_number = number_in(scenes, scene_label(cell));
    cell.setting = number_in(settings, differences(cell.options, first) || "base");
    const mine = (s) => s.file === cell.file && s.scene === cell.scene_number && s.setting === cell.setting;
    if (!series.some(mine)) series.push({ file: cell.file, scene: cell.scene_number, setting: cell.setting, cells: [] });
    series.find(mine).cells.push(cell);
}
for (const s of series) s.cells.sort((a, b) => a.side - b.side);
const ordered = series.flatMap((s) => s.cells);

/* "city.glb, rule shadow, old.json": what distinguishes a series from the others. */
const several = (labels, n) => labels.length > 1 ? [labels[n]] : [];
const names_of = (s) => [...several(settings, s.setting), ...several(files.map((f) => f.label), s.file)];
const series_name = (s) => [scenes[s.scene], ...names_of(s)].join(", ");
const row_name = (cell) => [cell.side, ...names_of(cell)].join(", ");

/* figures of cells ------------------------------------------------------------------------------------------------------------- */

/* "1 x 1" is a single tap; "9 x 9 smooth" */
const filter_of = (item) => `${item.filter_px} x ${item.filter_px}${item.smooth ? " smooth" : ""}`;
const TAP = "1 x 1";
const error_of = (cell, points, filter) => cell.errors.find((e) => e.points === points && filter_of(e) === filter);
const lookup_of = (cell, filter) => cell.lookups.find((l) => filter_of(l) === filter);
const rmse = (error) => error.rmse ?? Math.sqrt(error.wrong_share); /* single taps are right or wrong */
const size_of = (cell) => exactly(cell.size.file_bytes);
const time_of = (cell) => cell.bake.total_seconds;

/* value(side) = scale * side^slope: least squares of logarithms. null if there is one resolution only, or a value of 0 or less. */
function growth(s, value) {
    const points = s.cells.map((c) => [Math.log2(c.side), Math.log2(value(c))]);
    const mean = (n) => sum(points, (p) => p[n]) / points.length;
    const x = mean(0), y = mean(1), xx = sum(points, (p) => (p[0] - x) ** 2);
    const slope = sum(points, (p) => (p[0] - x) * (p[1] - y)) / xx;
    return xx > 1e-9 && Number.isFinite(slope) ? { slope, scale: 2 ** (y - slope * x), factor: 2 ** slope } : null;
}

/* charts ----------------------------------------------------------------------------------------------------------------------- */

const DASHES = [[[], "solid"], [[7, 4], "dashed"], [[2, 3], "dotted"], [[7, 3, 2, 3], "double"], [[12, 4], "groove"]];
const SCENES_MAX = 8, ROWS_MAX = 40, MASKS_AT = 4; /* voxels: the place of masks on an axis, before nodes of 8 */
const colour_of = (scene) => COLOURS[scene % COLOURS.length];
const mark_of = (setting) => MARKS[setting % MARKS.length];
const dash_of = (file) => DASHES[file % DASHES.length];
const NANOSECONDS = { text: nanoseconds, tick: nanoseconds };
const SHARE = { text: percent, tick: percent };
const TEXELS = { text: String, tick: String, binary: true };
const VOXELS = { tick: (value) => value <= MASKS_AT ? "masks" : `${value}³`, binary: true };
const COUNT = { tick: (value) => value < 1e3 ? `${value}` : value < 1e6 ? `${value / 1e3} k` : `${value / 1e6} M` };
const BYTES = { text: bytes, binary: true, tick: (value) => {
    const unit = Math.min(3, Math.max(0, Math.floor(Math.log2(value || 1) / 10)));
    return `${+(value / 1024 ** unit).toFixed(1)} ${["B", "KiB", "MiB", "GiB"][unit]}`;
} };

/* From 0 in steps of 1, 2 or 5; of whole KiB or MiB if the unit is binary. */
function linear_ticks(until, binary) {
    const scale = binary ? 1024 ** Math.max(0, Math.floor(Math.log2(until) / 10)) : 1, goal = until / scale / 7;
    const power = 10 ** Math.floor(Math.log10(goal)), step = scale * power * [1, 2, 5, 10].find((digit) => digit * power >= goal);
    return Array.from({ length: Math.floor(until / step) + 1 }, (_, n) => n * step);
}

/* lines ------------------------------------------------------------------------------------------------------------------------ */

/* The legend of colours, marks and dashes. */
const setting_keys = () => settings.length > 1 ? settings.map((s, n) => [el("b", {}, mark_of(n)[1]), s]) : [];
const file_keys = () => files.length > 1
    ? files.map((f, n) => [el("i", { class: "line", style: `border-top-style: ${dash_of(n)[1]}` }), f.label]) : [];
const scene_keys = () => scenes.map((s, n) => [swatch(colour_of(n)), s]);

const style_of = (s) => ({ borderColor: colour_of(s.scene), backgroundColor: colour_of(s.scene), colour: colour_of(s.scene),
    pointStyle: mark_of(s.setting)[0], borderDash: dash_of(s.file)[0], borderWidth: 1.5, pointRadius: 4, pointHoverRadius: 6 });

/* Points of a series: x_of(cell) and y_of(cell) are spreads, or undefined. A logarithmic axis cannot show 0. */
const points_of = (s, x_of, y_of, more) => s.cells.map((cell) => ({ cell, s, x: x_of(cell), y: y_of(cell), ...more }))
    .filter(({ x, y }) => x && y && x.median > 0 && y.median > 0);
const dataset = (s, points, more) => ({ ...style_of(s), spreads: points, ...more,
    data: points.map((p) => ({ ...p, x: p.x.median, y: p.y.median })) });

/* A chart of a value against resolution: value_of(cell), a spread. */
function growth_chart(name, what, label, unit, value_of) {
    const lines = series.map((s) => ({ s, points: points_of(s, (c) => exactly(c.side), value_of), fit: growth(s, (c) => value_of(c).median) }));
    const all = lines.flatMap((l) => l.points), fits = lines.filter((l) => l.fit), shown = lines.slice(0, 12);
    if (!all.length) return [];
    const keys = shown.map(({ s, fit }) => [el("b", { style: `color: ${colour_of(s.scene)}` }, mark_of(s.setting)[1]),
        `${fit ? `${fit.factor.toFixed(2)}-fold, slope ${fit.slope.toFixed(2)}` : "one resolution, no slope"}: ${series_name(s)}`]);
    if (lines.length > shown.length) keys.push([`and ${lines.length - shown.length} more, in the table`]);
    const title = fits.length
        ? `${what} grows ${range_text(fits.map((l) => l.fit.factor), (f) => `${f.toFixed(2)}-fold`)} with each doubling of the resolution`
        : `${what} by resolution: of one alone, so nothing is known of its growth`;
    const caption = "Both axes are logarithmic. Lines are fits by least squares to the logarithms of medians; bars reach from the least to "
        + "the greatest run.";
    const ends = ({ s, fit }) => [s.cells[0], s.cells.at(-1)].map((c) => ({ x: c.side, y: fit.scale * c.side ** fit.slope }));
    return [figure({ name, title, height: 300, keys, caption }, () => line_chart(
        [...lines.map((l) => dataset(l.s, l.points, { showLine: false })),
            ...fits.map((l) => ({ ...style_of(l.s), data: ends(l), pointRadius: 0, pointHitRadius: 0 }))],
        log_axis("texels a side", TEXELS, values_of(all, "x")), log_axis(label, unit, values_of(all, "y")),
        ({ s, cell, y }) => `${series_name(s)}, ${cell.side} texels: ${unit.text(y)}`))];
}

/* Errors at points of a kind, a line for each series and filter.
 * x_of(cell, filter): a spread, or undefined. y_of(error): a share. title(x, y): of ranges */
function error_chart({ name, points, filters, x_label, x_unit, x_of, y_label, y_of, title, caption }) {
    const share_of = (filter) => (cell) => {
        const error = error_of(cell, points, filter);
        return error && exactly(seen(y_of(error), error));
    };
    const lines = series.flatMap((s) => filters.map((filter) =>
        ({ s, filter, points: points_of(s, (c) => x_of(c, filter), share_of(filter), { filter }) })));
    const all = lines.flatMap((l) => l.points), many = filters.length > 1;
    if (!all.length) return [];
    /* one line of each scene has labels, as long as there is room; with filters, only its ends */
    const labels = (l) => l.s.setting || l.s.file || scenes.length > 3 || l.filter !== filters[0] ? []
        : l.points.map((p, n) => many && n && n < l.points.length - 1 ? "" : String(p.cell.side));
    const share = ({ cell, filter }) => y_of(error_of(cell, points, filter)); /* texts have the measured value, which may differ from the place where it is drawn */
    return [figure({ name: `${name}-${points}`,
        title: title(range_text(all.map((p) => p.x.median), x_unit.text), range_text(all.map(share), percent)), height: 320,
        keys: [...scene_keys(), ...setting_keys(), ...file_keys()], caption }, () => line_chart(
        lines.map((l) => dataset(l.s, l.points, { labels: labels(l) })),
        log_axis(x_label, x_unit, values_of(all, "x"), 0.1), log_axis(y_label, SHARE, values_of(all, "y")),
        ({ s, cell, filter, x }) => `${series_name(s)}, ${cell.side} texels${many ? `, ${filter}` : ""}: `
            + `${x_unit.text(x)}, ${percent(share({ cell, filter }))}`))];
}

/* A logarithmic axis cannot show zero wrong answers: they are drawn as half an answer. */
function seen(share, error) {
    const half = error.checked ? 0.5 / error.checked : 0;
    return share > 0 ? share : filter_of(error) === TAP ? half : Math.sqrt(half);
}

function error_charts() {
    const kinds = ["random", "surface"], filters = [...new Set(cells.flatMap((c) => c.lookups.map(filter_of)))];
    const wrong = (points, of) => ({ points, filters: [TAP], y_label: "wrong answers", y_of: (e) => e.wrong_share,
        title: (x, y) => `Of ${points} points, ${y} are answered wrong, by ${of} ${x}`,
        caption: "Single taps against ray tracing; lower and further left is better. Numbers are texels a side. Where nothing is wrong, "
            + "the mark is where half a point would be." });
    return [
        ...kinds.map((points) => ({ name: "error-bake", x_label: "bake time", x_unit: SECONDS, x_of: time_of, ...wrong(points, "bakes of") })),
        ...kinds.map((points) => ({ name: "error-bytes", x_label: "size of the file", x_unit: BYTES, x_of: size_of,
            ...wrong(points, "files of") })),
        ...kinds.map((points) => ({ name: "error-lookup", points, filters, x_label: "time of a lookup", x_unit: NANOSECONDS,
            x_of: (c, filter) => lookup_of(c, filter)?.nanoseconds, y_label: "root mean square error", y_of: rmse,
            title: (x, y) => `A lookup takes ${x}, and is off by ${y} at ${points} points`,
            caption: "Root mean square against the same filter over rays, of full light; for 1 tap that is the root of the share of wrong "
                + `answers. A line for each filter: ${filters.map((f) => f === TAP ? "1 tap" : f).join(", ")}. Numbers are texels `
                + "a side." })),
    ].flatMap(error_chart);
}

/* bars of one scene ------------------------------------------------------------------------------------------------------------ */

/* Greys before the maps, blue for them, greens from them to the DAG, browns for the file. */
const STAGE_COLOURS = { load: "#8d8a80", solids: "#a7a499", plan: "#75736b", gl: "#9a8fb0", maps: "#3d7ab8", pyramid: "#8ccf9d",
    masks: "#66b37e", insert: "#3c9260", compress: "#2a7048", merge: "#1f5737", encode: "#d0702a", smoke: "#7d7f9b", write: "#94742f" };

/* Parts of stacked bars: [{part, colour, values: one of each row}]. Parts below a hundredth of every bar are joined. */
function stack(rows, totals, parts_of) {
    const parts = new Map();
    for (const [row, cell] of rows.entries())
        for (const [part, colour, value] of parts_of(cell)) {
            if (!parts.has(part)) parts.set(part, { part, colour, values: rows.map(() => 0) });
            parts.get(part).values[row] += value;
        }
    const is_large = (p) => p.values.some((value, row) => value > 0 && value >= 0.01 * totals[row].median);
    const large = [...parts.values()].filter(is_large), small = [...parts.values()].filter((p) => !is_large(p));
    const others = { part: "others", colour: "#b9b6ab", values: rows.map((_, row) => sum(small, (p) => p.values[row])) };
    return small.length ? [...large, others] : large;
}

/* A bar for each cell of a scene. total_of(cell): a spread. parts_of(cell): [[name, colour, value]] */
function bar_chart({ name, scene, label, unit, total_of, parts_of, whole, caption }) {
    const all = ordered.filter((c) => c.scene_number === scene), rows = all.slice(0, ROWS_MAX), names = rows.map(row_name);
    const totals = rows.map(total_of), parts = stack(rows, totals, parts_of);
    if (!parts.length) return [];
    const share = (p, row) => totals[row].median > 0 ? p.values[row] / totals[row].median : 0;
    const shares = (p) => rows.map((_, row) => share(p, row));
    const largest = parts.reduce((a, b) => sum(shares(b), Number) > sum(shares(a), Number) ? b : a);
    const nodes = largest.part.includes("³") ? " nodes" : "", goes = totals.some((t) => t.median > 0);
    const title = scenes[scene] + (goes ? `: ${range_text(shares(largest), percent)} of ${whole} goes to ${largest.part}${nodes}` : "");
    const more = all.length > rows.length ? ` ${all.length - rows.length} more bakes are in the table.` : "";
    const most = Math.max(...totals.map((t) => t.max)) || 1;
    const row_label = (row) => {
        const room = Math.max(6, Math.floor(innerWidth / 22)); /* characters */
        return names[row].length > room ? `${names[row].slice(0, room - 1)}…` : names[row];
    };
    return [figure({ name: `${name}-${scene + 1}`, title, height: 62 + 24 * rows.length, keys: parts.map((p) => [swatch(p.colour), p.part]),
        caption: caption + more, wide: names.some((n) => n.length > 12) }, () => ({
        type: "bar", plugins: [whiskers],
        data: { labels: names, datasets: [
            ...parts.map((p) => ({ label: p.part, data: p.values, backgroundColor: p.colour, stack: "all", barPercentage: 0.8 })),
            { data: [], stack: "all", labels: totals.map((t) => unit.text(t.median)),
                spreads: totals.map((t, row) => ({ x: t, y: exactly(row) })) }] },
        options: { indexAxis: "y", interaction: { mode: "index", axis: "y" },
            scales: { x: axis(label, unit, linear_ticks(most * 1.1, unit.binary), { stacked: true, max: most * 1.2 }),
                y: { stacked: true, grid: { display: false }, ticks: { autoSkip: false, callback: row_label } } },
            plugins: { legend: { display: false }, tooltip: { callbacks: {
                label: (p) => `${p.dataset.label}: ${unit.text(p.raw)}, ${percent(share(parts[p.datasetIndex], p.dataIndex))}` } } } },
    }))];
}

const stage_chart = (scene) => bar_chart({ name: "stages", scene, label: "bake time by stage, medians", unit: SECONDS, total_of: time_of,
    parts_of: (cell) => cell.bake.stages.map((s, n) => [clean(s.name), STAGE_COLOURS[s.name] ?? colour_of(n), s.seconds.median]),
    whole: "the bake", caption: "A bar is a bake, labelled with its texels a side; the thin line at its end reaches from the least to the "
        + "greatest run. Stages below 1 % everywhere are joined." });

/* Of a DAG, the finest level first. */
const levels_of = (cell) => (cell.size.levels ?? []).map((l) => ({ ...l, n: l.side_voxels ? Math.log2(l.side_voxels) : 0 }))
    .sort((a, b) => a.n - b.n);

/* Of palette blocks. */
const PART_COLOURS = { tops: "#3d7ab8", patterns: "#94742f", pages: "#3c9260" };
const block_parts = (cell) => cell.size.parts ?? [];

function level_parts(cell) {
    const levels = [...levels_of(cell).map((l) => [level_name(l.n), level_colour(l.n), l.stored_bytes]),
        ...block_parts(cell).map((p) => [p.kind, PART_COLOURS[p.kind], p.stored_bytes])];
    const head = cell.size.file_bytes - sum(levels, ([, , size]) => size);
    return head > 0 && levels.length ? [...levels, ["head", "#8d8a80", head]] : levels;
}

const level_bytes_chart = (scene) => bar_chart({ name: "bytes-by-level", scene, label: "bytes of the file by part", unit: BYTES,
    total_of: size_of, parts_of: level_parts, whole: "the file", caption: "Of a DAG, masks are 8 x 8 texels of one depth; n³ are nodes of n "
        + "voxels a side. Of palette blocks, tops say where to look, with patterns that several pages use, and pages have the rest. Head is "
        + "what is no light's. What is below 1 % everywhere is joined." });

function level_counts_chart(scene) {
    const mine = ordered.filter((c) => c.scene_number === scene && levels_of(c).length);
    const points_of = (cell) => levels_of(cell).filter((l) => l.count > 0)
        .map((l) => ({ cell, n: l.n, x: l.n ? 2 ** l.n : MASKS_AT, y: l.count }));
    const all = mine.flatMap(points_of), share = sum(all, (p) => p.n <= 4 ? p.y : 0) / (sum(all, (p) => p.y) || 1);
    if (!mine.length) return [];
    const name_of = (cell) => [scenes[scene], row_name(cell)].join(", ");
    const one_at_least = (axis) => all.length ? all.map((p) => p[axis]) : [1];
    return [figure({ name: `nodes-by-level-${scene + 1}`, title: `${scenes[scene]}: masks, 8³ and 16³ are ${percent(share)} of all nodes and masks`,
        height: 300, keys: [...setting_keys(), ...file_keys()], caption: "A line is a bake. It ends at its root, which is as wide as the map." },
    () => line_chart(mine.map((cell) => ({ ...style_of({ ...cell, scene }), data: points_of(cell) })),
        log_axis("level, by the voxels a side of its nodes", VOXELS, one_at_least("x")), log_axis("nodes, masks", COUNT, one_at_least("y")),
        ({ cell, n, y }) => `${name_of(cell)} texels: ${count(y)} ${n ? `nodes of ${level_name(n)}` : "masks"}`))];
}

/* the head of the page --------------------------------------------------------------------------------------------------------- */

function show_head() {
    const shown = scenes.slice(0, 4), left = scenes.length - shown.length;
    const last = left ? `${left} more` : shown.length > 1 ? shown.pop() : "";
    document.title = "vxs: measured";
    show(el("h1", {}, `${plural(cells.length, "bake")} of ${shown.join(", ")}${last ? ` and ${last}` : ""}`));
    for (const { label, bench } of files) {
        const m = bench.machine, memory = `${significant(m.memory_bytes / 2 ** 30)} GiB`;
        show(soft(clean((files.length > 1 ? `${label}: ` : "")
            + `vxs ${bench.vxs}, measured ${bench.started} on ${plural(m.cores, "core")} of ${m.processor}, ${memory}, ${m.system}, `
            + `OpenGL by ${m.renderer}; medians of ${plural(bench.runs, "run")}`
            + (bench.points ? `, ${count(bench.points)} points of each kind.` : "."))));
    }
    if (settings.length > 1)
        show(soft(`Options that differ from the first bake's are named; a bake without such is called base${base ? `: ${base}` : ""}.`));
    const wrong = cells.flatMap((c) => error_of(c, "surface", TAP)?.wrong_share ?? []);
    const lookups = cells.flatMap((c) => lookup_of(c, TAP)?.nanoseconds.median ?? []);
    const answer = (question, values, unit, about) => values.length ? [fact(question, range_text(values, unit, " – "), about)] : [];
    show(el("div", { class: "facts" },
        ...answer("How big?", cells.map((c) => c.size.file_bytes), bytes, "a file"),
        ...answer("How long?", cells.map((c) => time_of(c).median), seconds, "a bake, median"),
        ...answer("How much memory?", cells.map((c) => c.bake.peak_bytes), bytes, "at the peak of a bake"),
        ...answer("How wrong?", wrong, percent, "of surface points"),
        ...answer("How fast?", lookups, nanoseconds, "a lookup of one tap")));
}

function show_charts() {
    const own = scenes.slice(0, SCENES_MAX).map((_, n) => n);
    const groups = [
        ["How long, and where the time goes", [...own.flatMap(stage_chart),
            ...growth_chart("growth-time", "Bake time", "bake time", SECONDS, time_of)]],
        ["How big, and where the bytes go", [...own.flatMap((n) => [...level_bytes_chart(n), ...level_counts_chart(n)]),
            ...growth_chart("growth-bytes", "The file", "size of the file", BYTES, size_of)]],
        ["How wrong, for how much", error_charts()]];
    for (const [title, charts] of groups) if (charts.length) show(el("h2", {}, title), el("div", { class: "plots" }, ...charts));
    if (scenes.length > own.length)
        show(soft(`${scenes.length - own.length} more scenes have no plots of their own; their figures are in the tables.`));
}

/* effects of settings ---------------------------------------------------------------------------------------------------------- */

/* Median, least and greatest of a / b. */
function ratio(pairs) {
    const values = pairs.filter(([a, b]) => a > 0 && b > 0).map(([a, b]) => a / b).sort((a, b) => a - b), half = values.length >> 1;
    if (!values.length) return "–";
    const median = (values.length % 2 ? values[half] : (values[half - 1] + values[half]) / 2).toFixed(2);
    return values.length > 1 ? [median, el("small", {}, ` ${values[0].toFixed(2)}–${values.at(-1).toFixed(2)}`)] : median;
}

function show_settings() {
    const figures = { "file": (c) => c.size.file_bytes, "in memory": (c) => c.size.memory_bytes, "bake time": (c) => time_of(c).median,
        "peak memory": (c) => c.bake.peak_bytes, "wrong at surfaces": (c) => error_of(c, "surface", TAP)?.wrong_share ?? 0 };
    const base_of = (cell) => cells.find((b) =>
        !b.setting && b.scene_number === cell.scene_number && b.file === cell.file && b.side === cell.side);
    const row = (name, setting) => {
        const pairs = ordered.filter((c) => c.setting === setting).map((c) => [c, base_of(c)]).filter(([, b]) => b);
        const ratios = Object.values(figures).map((figure) => ratio(pairs.map(([c, b]) => [figure(c), figure(b)])));
        return [text(name), count(pairs.length), ...ratios];
    };
    if (settings.length < 2) return;
    show(el("h2", {}, "What each setting is worth"),
        el("p", {}, "Each setting is divided by base, at the same scene and resolution: median, and least to greatest. Below 1 is "
            + "smaller, sooner, less wrong."),
        table(["setting", "bakes", ...Object.keys(figures)], settings.map(row).slice(1)));
}

/* tables ----------------------------------------------------------------------------------------------------------------------- */

const series_heads = ["scene", ...(settings.length > 1 ? ["setting"] : []), ...(files.length > 1 ? ["measured in"] : [])];
const series_cells = (s, scene) => [text(scenes[scene]), ...names_of(s).map((name) => text(name))];
const cell_heads = [...series_heads, "texels a side"];
const cell_cells = (c) => [...series_cells(c, c.scene_number), String(c.side)];
const below = (first, ...others) => [first, ...others.flatMap((other) => [el("br", {}), el("small", {}, other)])];
const beside = (value, more) => [value, el("small", {}, ` ${more}`)];
const spread = (s, unit = seconds) => s.min === s.max ? unit(s.median) : beside(unit(s.median), `${unit(s.min)}–${unit(s.max)}`);

/* rows_of(cell): the columns after its name, a list for each row */
function show_cells(title, heads, rows_of) {
    const rows = ordered.flatMap((c) => rows_of(c).map((row) => [...cell_cells(c), ...row]));
    if (rows.length && heads.length) show(el("h3", {}, title), table([...cell_heads, ...heads], rows));
}

/* A column for each name that occurs in parts_of(cell), a list of [name, content], of any cell. */
function show_parts(title, parts_of) {
    const parts = new Map(ordered.map((c) => [c, new Map(parts_of(c))]));
    const names = [...new Set([...parts.values()].flatMap((of) => [...of.keys()]))];
    show_cells(title, names, (c) => [names.map((name) => parts.get(c).get(name) ?? "")]);
}

/* Objects of a cell's coding: [[name, count]] */
const KEPT = { nodes: "nodes", masks: "masks", inserted_nodes: "nodes inserted", inserted_masks: "masks inserted", blocks: "blocks",
    tiles: "tiles", private_tiles: "with private palettes", patterns: "patterns", pages: "pages" };
function kept_of({ size }) {
    const kept = { ...size, ...size.palette_blocks };
    return Object.entries(KEPT).filter(([key]) => key in kept).map(([key, name]) => [name, kept[key]]);
}

function show_growth() {
    const figures = { "bake": (c) => time_of(c).median, "maps to words": (c) => c.bake.maps_to_words_seconds.median,
        "peak memory": (c) => c.bake.peak_bytes, "file": (c) => c.size.file_bytes, "in memory": (c) => c.size.memory_bytes,
        ...Object.fromEntries(ordered.flatMap(kept_of).map(([name]) => [name, (c) => Object.fromEntries(kept_of(c))[name]])) };
    const fold = (fit) => fit ? beside(`${fit.factor.toFixed(2)}-fold`, `slope ${fit.slope.toFixed(2)}`) : "–";
    const row = (s) => Object.values(figures).map((figure) => fold(growth(s, figure)));
    show(el("h3", {}, "Growth with each doubling of the resolution, and the fitted slope"),
        table([...series_heads, "resolutions", ...Object.keys(figures)],
            series.map((s) => [...series_cells(s, s.scene), count(s.cells.length), ...row(s)])));
}

const error_figures = (e) => filter_of(e) === TAP
    ? [percent(e.wrong_share), count(e.leaks), count(e.false_shadows), count(e.unexplained), percent(rmse(e)), ""]
    : ["", "", "", "", percent(e.rmse), percent(e.max_error)];

function show_figures() {
    show(el("h2", {}, "The figures"), soft("Times are medians, with least and greatest where they differ."));
    show_parts("Bakes", (c) => [
        ["bake", spread(time_of(c))], ["whole process", spread(c.bake.wall_seconds)], ["maps to words", spread(c.bake.maps_to_words_seconds)],
        ["peak memory", bytes(c.bake.peak_bytes)], ["file", bytes(c.size.file_bytes)], ["in memory", bytes(c.size.memory_bytes)],
        ["bit/texel", (8 * c.size.file_bytes / (c.side ** 2 * (c.maps || 1))).toFixed(3)],
        ...kept_of(c).map(([name, value]) => [name, count(value)]), ["triangles", count(c.triangles)], ["in solids", count(c.solid_triangles)]]);
    show_growth();
    show_parts("Stages: median seconds, and peak memory",
        (c) => c.bake.stages.map((s) => [clean(s.name), below(seconds(s.seconds.median), bytes(s.peak_bytes))]));
    show_parts("Levels: nodes or masks, and their bytes in the file and in memory",
        (c) => levels_of(c).map((l) => [level_name(l.n), below(count(l.count), bytes(l.stored_bytes), bytes(l.memory_bytes))]));
    show_parts("Parts of palette blocks, and their bytes in the file and in memory",
        (c) => block_parts(c).map((p) => [p.kind, below(count(p.count), bytes(p.stored_bytes), bytes(p.memory_bytes))]));
    show_cells("Errors against ray tracing", ["points", "filter", "checked", "wrong", "leaks", "false shadows", "unexplained",
        "root mean square", "greatest"],
    (c) => c.errors.map((e) => [text(`${e.points} points`), filter_of(e), count(e.checked), ...error_figures(e)]));
    show_cells("Lookups", ["filter", "a lookup", "rays for the same"], (c) => c.lookups.map((l) => [filter_of(l),
        spread(l.nanoseconds, nanoseconds), l.ray_nanoseconds?.median > 0 ? spread(l.ray_nanoseconds, nanoseconds) : ""]));
}

show_head();
show_charts();
show_settings();
show_figures();
draw_all(false);
