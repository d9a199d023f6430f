/* The page of measurements. data: {files: [{path, bench: docs/bench.schema.json}]}
 *
 * Cells of one scene, setting and file that differ in resolution alone form a series: a line of a chart. What a setting is follows from
 * the cells: only options that differ between them are named. A colour is a scene, a mark a setting, a dash a file.
 * SPDX-License-Identifier: GPL-3.0-or-later */

/* cells and what they belong to ----------------------------------------------------------------------------------------------- */

/* Equal for equal values, whatever the order of keys. */
const canonical = (value) => JSON.stringify(value, (_, v) =>
    v && typeof v === "object" && !Array.isArray(v) ? Object.fromEntries(Object.entries(v).sort()) : v);
const same = (a, b) => canonical(a) === canonical(b);
const word = (value) => typeof value === "string" ? value : JSON.stringify(value);

/* Two files of one name are told apart by their paths, and by a number where that does not help. */
const files = data.files.map(({ path, bench }, n) => {
    const others = data.files.filter((f) => base_name(f.path) === base_name(path));
    const before = data.files.slice(0, n).filter((f) => f.path === path).length;
    return { bench, label: clean(before ? `${path} (${before + 1})` : others.length > 1 ? path : base_name(path)) };
});
const cells = files.flatMap(({ bench }, file) => bench.cells.map((cell) => ({ ...cell, file, side: cell.options.resolution_px })));

/* A scene that is there with several lights first, or several suns, is named with them. */
function scene_label(cell) {
    const others = cells.filter((c) => c.scene === cell.scene), sun = cell.options.sun;
    const several = others.some((c) => c.light !== cell.light || (sun && c.options.sun && !same(c.options.sun, sun)));
    return clean(several ? `${cell.scene}, ${cell.light}${sun ? ` ${word(sun)}` : ""}` : cell.scene);
}

/* "rule shadow, stop insert": options that are not as `base` has them. A resolution is a place on a line, a sun belongs to its scene. */
function differences(given, base) {
    const named = (o) => Object.keys(o).filter((name) => name !== "resolution_px" && name !== "sun");
    return clean([...named(given).filter((name) => !same(given[name], base[name])).map((name) => `${name} ${word(given[name])}`),
        ...named(base).filter((name) => !(name in given)).map((name) => `no ${name}`)].join(", "));
}

const first = cells[0].options;
const agreed = Object.fromEntries(Object.entries(first).filter(([name, value]) => cells.every((c) => same(c.options[name], value))));
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

/* "city.glb, rule shadow, old.json": those that tell it from others. */
const several = (labels, n) => labels.length > 1 ? [labels[n]] : [];
const names_of = (s) => [...several(settings, s.setting), ...several(files.map((f) => f.label), s.file)];
const series_name = (s) => [scenes[s.scene], ...names_of(s)].join(", ");
const row_name = (cell) => [cell.side, ...names_of(cell)].join(", ");

/* figures of cells ------------------------------------------------------------------------------------------------------------ */

const error_of = (cell, points, filter) => cell.errors.find((e) => e.points === points && e.filter_px === filter);
const lookup_of = (cell, filter) => cell.lookups.find((l) => l.filter_px === filter);
const rmse = (error) => error.filter_px === 1 ? Math.sqrt(error.wrong_share) : error.rmse; /* single taps are right or wrong */
const exactly = (value) => ({ median: value, min: value, max: value });
const size_of = (cell) => exactly(cell.size.file_bytes);
const time_of = (cell) => cell.bake.total_seconds;
const range = (values) => values.length ? { min: Math.min(...values), max: Math.max(...values) } : null;

function range_text(values, unit, between = " to ") {
    const { min, max } = range(values);
    return unit(min) === unit(max) ? unit(min) : unit(min) + between + unit(max);
}

/* value(side) = scale * side^slope: least squares of logarithms. null of fewer than two resolutions, or where a value is not above 0. */
function growth(s, value) {
    const points = s.cells.map((c) => [Math.log2(c.side), Math.log2(value(c))]), mean = (n) => sum(points, (p) => p[n]) / points.length;
    const x = mean(0), y = mean(1), xx = sum(points, (p) => (p[0] - x) ** 2);
    const slope = sum(points, (p) => (p[0] - x) * (p[1] - y)) / xx;
    return xx > 1e-9 && Number.isFinite(slope) ? { slope, scale: 2 ** (y - slope * x), factor: 2 ** slope } : null;
}

/* charts ---------------------------------------------------------------------------------------------------------------------- */

const COLOURS = ["#3d7ab8", "#d0702a", "#3c9260", "#a9549c", "#c2485a", "#2f979c", "#94742f", "#7b7f8c"]; /* seen on white and on black */
const MARKS = [["circle", "●"], ["rect", "■"], ["triangle", "▲"], ["rectRot", "◆"], ["crossRot", "✕"], ["cross", "✚"], ["star", "✳"]];
const DASHES = [[], [7, 4], [2, 3], [7, 3, 2, 3], [12, 4]], DASH_NAMES = ["solid", "dashed", "dotted", "double", "groove"];
const SCENES_MAX = 8, ROWS_MAX = 40, MASKS_AT = 4; /* voxels: where masks stand on an axis, before nodes of 8 */
const colour_of = (scene) => COLOURS[scene % COLOURS.length];
const mark_of = (setting) => MARKS[setting % MARKS.length];
const drawn = []; /* [canvas, function that makes its chart's configuration] */
let printing = false;

/* Charts are painted, so they do not follow the page's colours: they are painted anew when those change. */
function draw(canvas, configuration) {
    const style = getComputedStyle(document.documentElement), ink = (name, paper) => printing ? paper : style.getPropertyValue(name);
    Chart.getChart(canvas)?.destroy();
    Object.assign(Chart.defaults, { color: ink("--ink", "#22221f"), borderColor: ink("--rule", "#dcd9cf"), animation: false,
        maintainAspectRatio: false });
    new Chart(canvas, configuration());
}

function draw_all(print) {
    printing = print;
    for (const [canvas, configuration] of drawn) draw(canvas, configuration);
}

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw_all(false));
addEventListener("beforeprint", () => draw_all(true));
addEventListener("afterprint", () => draw_all(false));

/* height: CSS pixels */
function chart(name, title, height, keys, caption, configuration, wide) {
    const canvas = el("canvas", { role: "img", "aria-label": `${title}. Its figures are in the tables below.` });
    drawn.push([canvas, configuration]);
    return el("figure", { id: name, class: wide ? "wide" : "" }, el("h3", {}, title),
        el("div", { class: "canvas", style: `height: ${height}px` }, canvas), key(...keys), el("figcaption", {}, caption));
}

/* Ticks at powers of two where a unit is binary, else at 1, 2, 5 and 10 while there is room. */
function log_ticks(from, until, binary) {
    if (binary) {
        const low = Math.ceil(Math.log2(from) - 1e-9), high = Math.floor(Math.log2(until) + 1e-9), step = 1 + Math.floor((high - low) / 6);
        return Array.from({ length: Math.max(0, Math.floor((high - low) / step) + 1) }, (_, n) => 2 ** (low + n * step));
    }
    const decades = Math.log10(until / from), ticks = [];
    for (let n = Math.floor(Math.log10(from)); n <= Math.ceil(Math.log10(until)); n += Math.max(1, Math.ceil(decades / 8)))
        ticks.push(...(decades > 2.4 ? [1] : [1, 2, 5]).map((digit) => digit * 10 ** n));
    return ticks.filter((value) => value >= from * 0.9999 && value <= until * 1.0001);
}

/* From 0 in steps of 1, 2 or 5, of whole KiB or MiB where a unit is binary. */
function linear_ticks(until, binary) {
    const scale = binary ? 1024 ** Math.max(0, Math.floor(Math.log2(until) / 10)) : 1, goal = until / scale / 7;
    const power = 10 ** Math.floor(Math.log10(goal)), step = scale * power * [1, 2, 5, 10].find((digit) => digit * power >= goal);
    return Array.from({ length: Math.floor(until / step) + 1 }, (_, n) => n * step);
}

/* unit: figure as text. values: all that lie on the axis, above 0. room: more of its length behind the last, for labels. */
function log_axis(label, unit, values, binary, room = 0) {
    const { min, max } = range(values), pad = max / min < 1.8 ? 1.5 : Math.max(1.15, (max / min) ** 0.06);
    const from = min / pad, until = max * pad * (max / min) ** room, ticks = log_ticks(from, until, binary);
    return { type: "logarithmic", min: from, max: until, title: { display: true, text: label },
        afterBuildTicks: (axis) => { axis.ticks = (ticks.length ? ticks : [Math.sqrt(from * until)]).map((value) => ({ value })); },
        ticks: { callback: unit, maxRotation: 0, autoSkipPadding: 8 } };
}

/* Bytes without parts of them, for ticks. */
const bytes_tick = (value) => value < 1024 ? `${+value.toFixed(1)} B` : value < 1024 ** 2 ? `${+(value / 1024).toFixed(1)} KiB`
    : value < 1024 ** 3 ? `${+(value / 1024 ** 2).toFixed(1)} MiB` : `${+(value / 1024 ** 3).toFixed(1)} GiB`;
const count_tick = (value) => value < 1e3 ? `${value}` : value < 1e6 ? `${value / 1e3} k` : `${value / 1e6} M`;
const voxels_tick = (value) => value <= MASKS_AT ? "masks" : `${value}³`;

/* Lines from the least to the greatest run, and labels beside points. A dataset's spreads: [{x, y}] spreads of its points. */
const whiskers_and_labels = {
    afterDatasetsDraw({ ctx, data: { datasets }, scales: { x, y }, options: { color } }) {
        ctx.save();
        ctx.font = "11px sans-serif";
        for (const { spreads = [], labels = [], colour = color } of datasets)
            for (const [n, spread] of spreads.entries()) {
                ctx.strokeStyle = ctx.fillStyle = colour;
                const at = (axis, value, otherwise) => axis.getPixelForValue(axis.type === "category" || value > 0 ? value : otherwise);
                const [px, py] = [at(x, spread.x.median), at(y, spread.y.median)];
                ctx.beginPath();
                ctx.moveTo(at(x, spread.x.min, spread.x.median), py);
                ctx.lineTo(at(x, spread.x.max), py);
                ctx.moveTo(px, at(y, spread.y.min, spread.y.median));
                ctx.lineTo(px, at(y, spread.y.max));
                ctx.stroke();
                if (labels[n]) ctx.fillText(labels[n], at(x, spread.x.max) + 6, py - (x.type === "linear" ? -4 : 5));
            }
        ctx.restore();
    },
};

/* What colours, marks and dashes mean. */
const setting_keys = () => settings.length > 1 ? settings.map((s, n) => [el("b", {}, mark_of(n)[1]), s]) : [];
const file_keys = () => files.length > 1 ? files.map((f, n) =>
    [el("i", { class: "line", style: `border-top-style: ${DASH_NAMES[n % DASHES.length]}` }), f.label]) : [];
const keys = () => [...scenes.map((s, n) => [swatch(colour_of(n)), s]), ...setting_keys(), ...file_keys()];

const line_style = (s) => ({ borderColor: colour_of(s.scene), backgroundColor: colour_of(s.scene), colour: colour_of(s.scene),
    pointStyle: mark_of(s.setting)[0], borderDash: DASHES[s.file % DASHES.length], borderWidth: 1.5, pointRadius: 4, pointHoverRadius: 6 });

/* A line chart's datasets, scales, and what is said of a point. */
const line_chart = (datasets, x, y, tell) => ({ type: "line", data: { datasets }, plugins: [whiskers_and_labels],
    options: { scales: { x, y }, parsing: false, interaction: { mode: "nearest", intersect: true },
        plugins: { legend: { display: false }, tooltip: { callbacks: { title: () => "", label: ({ raw }) => tell(raw) },
            filter: ({ raw }) => raw.cell } } } });

/* The points that a chart's line has: x and y are spreads, above 0. */
const points_of = (s, x_of, y_of) => s.cells.map((cell) => ({ cell, s, x: x_of(cell), y: y_of(cell) }))
    .filter(({ x, y }) => x && y && x.median > 0 && y.median > 0);
const spread_values = (points, axis) => points.flatMap((p) => [p[axis].min, p[axis].median, p[axis].max]).filter((v) => v > 0);
const dataset = (s, points, more) => ({ ...line_style(s), spreads: points,
    data: points.map((p) => ({ ...p, x: p.x.median, y: p.y.median })), ...more });

/* growth with resolution ------------------------------------------------------------------------------------------------------ */

function growth_chart(name, what, label, unit, tick, binary, value) {
    const lines = series.map((s) => ({ s, points: points_of(s, (c) => exactly(c.side), value), fit: growth(s, (c) => value(c).median) }));
    const all = lines.flatMap((l) => l.points), fits = lines.filter((l) => l.fit), shown = lines.slice(0, 12);
    if (!all.length) return [];
    const ends = ({ s, fit }) => [s.cells[0], s.cells.at(-1)].map((c) => ({ x: c.side, y: fit.scale * c.side ** fit.slope }));
    const title = fits.length ? `${what} grows ${range_text(fits.map((l) => l.fit.factor), (f) => `${f.toFixed(2)}-fold`)} with each doubling of the resolution`
        : `${what} by resolution: of one alone, so nothing is known of its growth`;
    const keys = shown.map(({ s, fit }) => [el("b", { style: `color: ${colour_of(s.scene)}` }, mark_of(s.setting)[1]),
        `${fit ? `${fit.factor.toFixed(2)}-fold, slope ${fit.slope.toFixed(2)}` : "one resolution, no slope"}: ${series_name(s)}`]);
    if (lines.length > shown.length) keys.push([`and ${lines.length - shown.length} more, in the table`]);
    return [chart(name, title, 300, keys, "Both axes are logarithmic. Lines are fits by least squares to the logarithms of medians; bars "
        + "reach from the least to the greatest run.", () => line_chart(
        [...lines.map((l) => dataset(l.s, l.points, { showLine: false })),
            ...fits.map((l) => ({ ...line_style(l.s), data: ends(l), pointRadius: 0, pointHitRadius: 0 }))],
        log_axis("texels a side", String, spread_values(all, "x"), true), log_axis(label, tick, spread_values(all, "y"), binary),
        ({ s, cell, y }) => `${series_name(s)}, ${cell.side} texels: ${unit(y)}`))];
}

/* errors ---------------------------------------------------------------------------------------------------------------------- */

/* No wrong answer has no place on a logarithmic axis: it is drawn where half an answer would be. */
function seen(value, error) {
    const half = error.checked ? 0.5 / error.checked : 0;
    return exactly(value > 0 ? value : error.filter_px === 1 ? half : Math.sqrt(half));
}

/* A line for each series and filter. x_of(cell, filter): a spread, or undefined. */
function error_chart(name, points, filters, x_label, x_unit, x_tick, binary, x_of, y_label, y_of, title, caption) {
    const of_points = (y) => (cell) => { const e = error_of(cell, points, y.filter); return e && seen(y_of(e), e); };
    const lines = series.flatMap((s) => filters.map((filter) =>
        ({ s, filter, points: points_of(s, (c) => x_of(c, filter), of_points({ filter })) })));
    const all = lines.flatMap((l) => l.points);
    if (!all.length) return [];
    const labels = ({ s, filter, points }) => s.setting || s.file || scenes.length > 3 || filter !== filters[0] ? []
        : points.map((p, n) => filters.length === 1 || !n || n === points.length - 1 ? String(p.cell.side) : "");
    return [chart(name, title(range_text(all.map((p) => p.x.median), x_unit), range_text(all.map((p) => p.y.median), percent)), 320, keys(),
        caption, () => line_chart(lines.map((l) => dataset(l.s, l.points.map((p) => ({ ...p, filter: l.filter })), { labels: labels(l) })),
            log_axis(x_label, x_tick, spread_values(all, "x"), binary, 0.1), log_axis(y_label, percent, spread_values(all, "y")),
            ({ s, cell, filter, x, y }) => `${series_name(s)}, ${cell.side} texels${filters.length > 1 ? `, ${filter} x ${filter}` : ""}: `
                + `${x_unit(x)}, ${percent(y)}`))];
}

function error_charts() {
    const kinds = ["random", "surface"], filters = [...new Set(cells.flatMap((c) => c.lookups.map((l) => l.filter_px)))];
    const wrong = (name, of, label, unit, tick, binary, x_of) => kinds.flatMap((points) => error_chart(`${name}-${points}`, points, [1],
        label, unit, tick, binary, x_of, "wrong answers", (e) => e.wrong_share,
        (x, y) => `Of ${points} points, ${y} are answered wrong, by ${of} ${x}`,
        "Single taps against ray tracing; lower and further left is better. Numbers are texels a side. Where nothing is wrong, the mark is "
        + "where half a point would be."));
    return [...wrong("error-bake", "bakes of", "bake time", seconds, seconds, false, time_of),
        ...wrong("error-bytes", "files of", "size of the file", bytes, bytes_tick, true, size_of),
        ...kinds.flatMap((points) => error_chart(`error-lookup-${points}`, points, filters, "time of a lookup", nanoseconds, nanoseconds,
            false, (c, filter) => lookup_of(c, filter)?.nanoseconds, "root mean square error", rmse,
            (x, y) => `A lookup takes ${x}, and is off by ${y} at ${points} points`,
            "Root mean square against the same filter over rays, of full light; for 1 tap that is the root of the share of wrong answers. "
            + `A line for each filter, from left to right ${filters.map((f) => f === 1 ? "1 tap" : `${f} x ${f}`).join(", ")}. `
            + "Numbers are texels a side."))];
}

/* bars of one scene ----------------------------------------------------------------------------------------------------------- */

/* Greys before the maps, blue for them, greens from them to the DAG, browns for the file. */
const STAGE_COLOURS = { load: "#8d8a80", solids: "#a7a499", plan: "#75736b", gl: "#9a8fb0", maps: "#3d7ab8", pyramid: "#8ccf9d",
    masks: "#66b37e", insert: "#3c9260", compress: "#2a7048", merge: "#1f5737", encode: "#d0702a", write: "#94742f" };

/* A bar for each cell of a scene. parts_of(cell): [[name, colour, value]]; what is nowhere a hundredth of a bar is joined. */
function bar_chart(name, scene, label, unit, tick, total_of, parts_of, whole, caption) {
    const all = ordered.filter((c) => c.scene_number === scene), rows = all.slice(0, ROWS_MAX), parts = new Map();
    for (const [row, cell] of rows.entries())
        for (const [part, colour, value] of parts_of(cell)) {
            if (!parts.has(part)) parts.set(part, { part, colour, values: rows.map(() => 0) });
            parts.get(part).values[row] += value;
        }
    if (!parts.size) return [];
    const totals = rows.map(total_of), share = (p, row) => totals[row].median > 0 ? p.values[row] / totals[row].median : 0;
    const large = [...parts.values()].filter((p) => rows.some((_, row) => share(p, row) >= 0.01));
    const small = [...parts.values()].filter((p) => !large.includes(p));
    if (small.length) large.push({ part: "others", colour: "#b9b6ab", values: rows.map((_, row) => sum(small, (p) => p.values[row])) });
    const shares = (p) => rows.map((_, row) => share(p, row)), largest = large.reduce((a, b) => sum(shares(b), Number) > sum(shares(a), Number) ? b : a);
    const part = largest.part + (largest.part.includes("³") ? " nodes" : "");
    const title = totals.some((t) => t.median > 0) ? `${scenes[scene]}: ${range_text(shares(largest), percent)} of ${whole} goes to ${part}`
        : scenes[scene];
    const names = rows.map(row_name), most = Math.max(...totals.map((t) => t.max)) || 1;
    const ticks = linear_ticks(most * 1.1, unit === bytes);
    const more = all.length > rows.length ? ` ${all.length - rows.length} more bakes are in the table.` : "";
    const cut = (text, length) => text.length > length ? `${text.slice(0, length - 1)}…` : text;
    return [chart(name, title, 62 + 24 * rows.length, large.map((p) => [swatch(p.colour), p.part]), caption + more, () => ({
        type: "bar", plugins: [whiskers_and_labels],
        data: { labels: names, datasets: [
            ...large.map((p) => ({ label: p.part, data: p.values, backgroundColor: p.colour, stack: "all", barPercentage: 0.8 })),
            { data: [], stack: "all", spreads: totals.map((t, row) => ({ x: t, y: exactly(row) })), labels: totals.map((t) => unit(t.median)) }] },
        options: { indexAxis: "y", interaction: { mode: "index", axis: "y" },
            scales: { x: { stacked: true, max: most * 1.2, title: { display: true, text: label },
                afterBuildTicks: (axis) => { axis.ticks = ticks.map((value) => ({ value })); },
                ticks: { callback: tick, maxRotation: 0, autoSkipPadding: 8 } },
            y: { stacked: true, grid: { display: false },
                ticks: { autoSkip: false, callback: (row) => cut(names[row], Math.max(6, Math.floor(innerWidth / 22))) } } },
            plugins: { legend: { display: false }, tooltip: { callbacks: {
                label: (p) => `${p.dataset.label}: ${unit(p.raw)}, ${percent(share(large[p.datasetIndex], p.dataIndex))}` } } } },
    }), names.some((n) => n.length > 12))];
}

const stage_chart = (scene) => bar_chart(`stages-${scene + 1}`, scene, "bake time by stage, medians", seconds, seconds, time_of,
    (cell) => cell.bake.stages.map((s, n) => [clean(s.name), STAGE_COLOURS[s.name] ?? colour_of(n), s.seconds.median]), "the bake",
    "A bar is a bake, labelled with its texels a side; the thin line at its end reaches from the least to the greatest run. Stages below 1 % "
    + "everywhere are joined.");

/* The finest level first. */
const levels_of = (cell) => cell.size.levels.map((l) => ({ ...l, n: l.side_voxels ? Math.log2(l.side_voxels) : 0 })).sort((a, b) => a.n - b.n);

function level_bytes_chart(scene) {
    const parts = (cell) => {
        const levels = levels_of(cell).map((l) => [level_name(l.n), level_colour(l.n), l.stored_bytes]);
        const head = cell.size.file_bytes - sum(levels, ([, , size]) => size);
        return head > 0 && levels.length ? [...levels, ["head", "#8d8a80", head]] : levels;
    };
    return bar_chart(`bytes-by-level-${scene + 1}`, scene, "bytes of the file by level", bytes, bytes_tick, size_of, parts, "the file",
        "Masks are 8 x 8 texels of one depth; n³ are nodes of n voxels a side. Head is what is no light's. What is below 1 % everywhere is joined.");
}

function level_counts_chart(scene) {
    const lines = series.filter((s) => s.scene === scene).flatMap((s) => s.cells.map((cell) => ({ s, cell,
        points: levels_of(cell).filter((l) => l.count > 0).map((l) => ({ cell, s, n: l.n, x: l.n ? 2 ** l.n : MASKS_AT, y: l.count })) })));
    const all = lines.flatMap((l) => l.points), fine = sum(all, (p) => p.n <= 4 ? p.y : 0);
    if (!lines.some((l) => l.cell.size.levels.length)) return [];
    const one = (values) => values.length ? values : [1];
    return [chart(`nodes-by-level-${scene + 1}`, `${scenes[scene]}: masks, 8³ and 16³ are ${percent(fine / (sum(all, (p) => p.y) || 1))} of all nodes and masks`,
        300, [...setting_keys(), ...file_keys()], "A line is a bake. It ends at its root, which is as wide as the map.", () => line_chart(
            lines.map(({ s, points }) => ({ ...line_style(s), colour: undefined, data: points })),
            log_axis("level, by the voxels a side of its nodes", voxels_tick, one(all.map((p) => p.x)), true),
            log_axis("nodes, masks", count_tick, one(all.map((p) => p.y))),
            ({ s, cell, n, y }) => `${series_name(s)}, ${cell.side} texels: ${count(y)} ${n ? `nodes of ${level_name(n)}` : "masks"}`))];
}

/* the head of the page -------------------------------------------------------------------------------------------------------- */

function show_head() {
    const shown = scenes.slice(0, 4), left = scenes.length - shown.length, last = left ? `${left} more` : shown.length > 1 ? shown.pop() : null;
    document.title = "vxs: measured";
    show(el("h1", {}, `${plural(cells.length, "bake")} of ${shown.join(", ")}${last ? ` and ${last}` : ""}`));
    for (const { label, bench } of files) {
        const m = bench.machine, points = bench.points ? `, ${count(bench.points)} points of each kind` : "";
        show(soft(clean(`${files.length > 1 ? `${label}: ` : ""}vxs ${bench.vxs}, measured ${bench.started} on ${plural(m.cores, "core")} of ${m.processor}, `
            + `${Number((m.memory_bytes / 2 ** 30).toPrecision(3))} GiB, ${m.system}, OpenGL by ${m.renderer}; medians of ${plural(bench.runs, "run")}${points}.`)));
    }
    const answer = (question, values, unit, about) => values.length ? [fact(question, range_text(values, unit, " – "), about)] : [];
    show(el("div", { class: "facts" },
        ...answer("How big?", cells.map((c) => c.size.file_bytes), bytes, "a file"),
        ...answer("How long?", cells.map((c) => time_of(c).median), seconds, "a bake, median"),
        ...answer("How much memory?", cells.map((c) => c.bake.peak_bytes), bytes, "at the peak of a bake"),
        ...answer("How wrong?", cells.flatMap((c) => error_of(c, "surface", 1)?.wrong_share ?? []), percent, "of surface points"),
        ...answer("How fast?", cells.flatMap((c) => lookup_of(c, 1)?.nanoseconds.median ?? []), nanoseconds, "a lookup of one tap")));
}

function show_charts() {
    const own = scenes.slice(0, SCENES_MAX).map((_, n) => n);
    const groups = [
        ["How long, and where the time goes", [...own.flatMap(stage_chart),
            ...growth_chart("growth-time", "Bake time", "bake time", seconds, seconds, false, time_of)]],
        ["How big, and where the bytes go", [...own.flatMap((n) => [...level_bytes_chart(n), ...level_counts_chart(n)]),
            ...growth_chart("growth-bytes", "The file", "size of the file", bytes, bytes_tick, true, size_of)]],
        ["How wrong, for how much", error_charts()]];
    for (const [title, charts] of groups) if (charts.length) show(el("h2", {}, title), el("div", { class: "plots" }, ...charts));
    if (scenes.length > own.length)
        show(soft(`${scenes.length - own.length} more scenes have no plots of their own; their figures are in the tables.`));
}

/* what settings are worth ----------------------------------------------------------------------------------------------------- */

function ratio(pairs) {
    const values = pairs.filter(([a, b]) => a > 0 && b > 0).map(([a, b]) => a / b).sort((a, b) => a - b), half = values.length >> 1;
    if (!values.length) return "–";
    const median = values.length % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
    return values.length > 1 ? [median.toFixed(2), el("small", {}, ` ${values[0].toFixed(2)}–${values.at(-1).toFixed(2)}`)] : median.toFixed(2);
}

function show_settings() {
    if (settings.length < 2) return;
    const figures = [(c) => c.size.file_bytes, (c) => c.size.memory_bytes, (c) => time_of(c).median, (c) => c.bake.peak_bytes,
        (c) => error_of(c, "surface", 1)?.wrong_share ?? 0];
    const base_of = (cell) => cells.find((b) => !b.setting && b.scene_number === cell.scene_number && b.file === cell.file && b.side === cell.side);
    show(el("h2", {}, "What each setting is worth"),
        el("p", {}, `Base is ${base || "the first setting"}. Each other setting is divided by it, at the same scene and resolution: median, `
            + "and least to greatest. Below 1 is smaller, sooner, less wrong."),
        table(["setting", "bakes", "file", "in memory", "bake time", "peak memory", "wrong at surfaces"], settings.slice(1).map((name, n) => {
            const pairs = ordered.filter((c) => c.setting === n + 1).map((c) => [c, base_of(c)]).filter(([, b]) => b);
            return [text(name), count(pairs.length), ...figures.map((figure) => ratio(pairs.map(([c, b]) => [figure(c), figure(b)])))];
        })));
}

/* tables ---------------------------------------------------------------------------------------------------------------------- */

const series_heads = ["scene", ...(settings.length > 1 ? ["setting"] : []), ...(files.length > 1 ? ["measured in"] : [])];
const series_cells = (s, scene) => [text(scenes[scene]), ...names_of(s).map((name) => text(name))];
const cell_heads = [...series_heads, "texels a side"];
const cell_cells = (c) => [...series_cells(c, c.scene_number), String(c.side)];
const lines = (...parts) => parts.flatMap((part, n) => n ? [el("br", {}), part] : [part]);

function spread(s, unit = seconds) {
    return s.min === s.max ? unit(s.median) : [unit(s.median), el("small", {}, ` ${unit(s.min)}–${unit(s.max)}`)];
}

function show_table(title, heads, rows) {
    if (rows.length) show(el("h3", {}, title), table(heads, rows));
}

function show_bakes() {
    const bit_per_texel = (c) => (8 * c.size.file_bytes / (c.side ** 2 * (c.maps || 1))).toFixed(3);
    show_table("Bakes", [...cell_heads, "bake", "whole process", "maps to DAG", "peak memory", "file", "in memory", "bit/texel", "nodes", "masks",
        "nodes inserted", "masks inserted", "triangles", "in solids"], ordered.map((c) => [...cell_cells(c), spread(time_of(c)),
        spread(c.bake.wall_seconds), spread(c.bake.maps_to_dag_seconds), bytes(c.bake.peak_bytes), bytes(c.size.file_bytes),
        bytes(c.size.memory_bytes), bit_per_texel(c), ...[c.size.nodes, c.size.masks, c.size.inserted_nodes, c.size.inserted_masks,
            c.triangles, c.solid_triangles].map(count)]));
}

function show_growth() {
    const kinds = { "bake": (c) => time_of(c).median, "maps to DAG": (c) => c.bake.maps_to_dag_seconds.median, "peak memory": (c) => c.bake.peak_bytes,
        "file": (c) => c.size.file_bytes, "in memory": (c) => c.size.memory_bytes, "nodes": (c) => c.size.nodes, "masks": (c) => c.size.masks };
    const fold = (fit) => fit ? [`${fit.factor.toFixed(2)}-fold`, el("small", {}, ` slope ${fit.slope.toFixed(2)}`)] : "–";
    show_table("Growth with each doubling of the resolution, and the fitted slope", [...series_heads, "resolutions", ...Object.keys(kinds)],
        series.map((s) => [...series_cells(s, s.scene), count(s.cells.length), ...Object.values(kinds).map((value) => fold(growth(s, value)))]));
}

function show_stages() {
    const names = [...new Set(ordered.flatMap((c) => c.bake.stages.map((s) => s.name)))];
    const stage = (s) => s ? lines(seconds(s.seconds.median), el("small", {}, bytes(s.peak_bytes))) : "";
    if (names.length) show_table("Stages: median seconds, and peak memory", [...cell_heads, ...names.map(clean)],
        ordered.map((c) => [...cell_cells(c), ...names.map((name) => stage(c.bake.stages.find((s) => s.name === name)))]));
}

function show_levels() {
    const all = [...new Set(ordered.flatMap((c) => levels_of(c).map((l) => l.n)))].sort((a, b) => a - b);
    const level = (l) => l ? lines(count(l.count), el("small", {}, bytes(l.stored_bytes)), el("small", {}, bytes(l.memory_bytes))) : "";
    if (all.length) show_table("Levels: nodes or masks, and their bytes in the file and in memory", [...cell_heads, ...all.map(level_name)],
        ordered.map((c) => [...cell_cells(c), ...all.map((n) => level(levels_of(c).find((l) => l.n === n)))]));
}

function show_errors() {
    const taps = (e) => [percent(e.wrong_share), count(e.leaks), count(e.false_shadows), count(e.unexplained), percent(rmse(e)), ""];
    const filtered = (e) => ["", "", "", "", percent(e.rmse), percent(e.max_error)];
    show_table("Errors against ray tracing", [...cell_heads, "points", "filter", "checked", "wrong", "leaks", "false shadows", "unexplained",
        "root mean square", "greatest"], ordered.flatMap((c) => c.errors.map((e) => [...cell_cells(c), text(`${e.points} points`),
        `${e.filter_px} x ${e.filter_px}`, count(e.checked), ...(e.filter_px === 1 ? taps(e) : filtered(e))])));
}

function show_lookups() {
    show_table("Lookups", [...cell_heads, "filter", "a lookup", "rays for the same"], ordered.flatMap((c) => c.lookups.map((l) => [...cell_cells(c),
        `${l.filter_px} x ${l.filter_px}`, spread(l.nanoseconds, nanoseconds), l.ray_nanoseconds?.median > 0 ? spread(l.ray_nanoseconds, nanoseconds) : ""])));
}

show_head();
show_charts();
show_settings();
show(el("h2", {}, "The figures"), soft("Times are medians, with least and greatest where they differ."));
show_bakes();
show_growth();
show_stages();
show_levels();
show_errors();
show_lookups();
draw_all(false);
