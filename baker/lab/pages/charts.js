/* Charts of measurements: figures that are redrawn when colours change, units, axes, lines.
 * SPDX-License-Identifier: GPL-3.0-or-later */

/* A value of several runs is a spread: {median, min, max}. */
const exactly = (value) => ({ median: value, min: value, max: value });
const range = (values) => values.length ? { min: Math.min(...values), max: Math.max(...values) } : null;

function range_text(values, unit, between = " to ") {
    const { min, max } = range(values);
    return unit(min) === unit(max) ? unit(min) : unit(min) + between + unit(max);
}

const COLOURS = ["#3d7ab8", "#d0702a", "#3c9260", "#a9549c", "#c2485a", "#2f979c", "#94742f", "#7b7f8c"]; /* on white and on black */
const MARKS = [["circle", "●"], ["rect", "■"], ["triangle", "▲"], ["rectRot", "◆"], ["crossRot", "✕"], ["cross", "✚"], ["star", "✳"]];
const drawn = []; /* [canvas, function that makes the configuration of its chart] */
let printing = false;

/* Charts are canvases, which do not follow the page's colours: they are redrawn when these change. */
function draw(canvas, configuration) {
    const style = getComputedStyle(document.documentElement);
    const ink = (name, on_paper) => printing ? on_paper : style.getPropertyValue(name);
    Chart.getChart(canvas)?.destroy();
    Object.assign(Chart.defaults, { animation: false, maintainAspectRatio: false,
        color: ink("--ink", "#22221f"), borderColor: ink("--rule", "#dcd9cf") });
    new Chart(canvas, configuration());
}

function draw_all(for_print) {
    printing = for_print;
    for (const [canvas, configuration] of drawn) draw(canvas, configuration);
}

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw_all(false));
addEventListener("beforeprint", () => draw_all(true));
addEventListener("afterprint", () => draw_all(false));

/* A figure with a chart that is drawn later. height: CSS pixels; keys: the legend of colours and marks. */
function figure({ name, title, height, keys, caption, wide = false }, configuration) {
    const canvas = el("canvas", { role: "img", "aria-label": `${title}. Its figures are in the tables below.` });
    drawn.push([canvas, configuration]);
    return el("figure", { id: name, class: wide ? "wide" : "" }, el("h3", {}, title),
        el("div", { class: "canvas", style: `height: ${height}px` }, canvas), key(...keys), el("figcaption", {}, caption));
}

/* Texts of a value in a chart: `text` at the mouse, `tick` on an axis, in powers of two or in decades. */
const SECONDS = { text: seconds, tick: seconds };

/* Ticks at powers of two if the unit is binary, else at 1, 2, 5 and 10, as long as there is room. */
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

const axis = (label, unit, ticks, more) => ({ title: { display: true, text: label },
    afterBuildTicks: (scale) => { scale.ticks = ticks.map((value) => ({ value })); },
    ticks: { callback: unit.tick, maxRotation: 0, autoSkipPadding: 8 }, ...more });

/* values: all values of the axis, above 0. room: additional length behind the last one, for labels. */
function log_axis(label, unit, values, room = 0) {
    const { min, max } = range(values), pad = max / min < 1.8 ? 1.5 : Math.max(1.15, (max / min) ** 0.06);
    const from = min / pad, until = max * pad * (max / min) ** room, ticks = log_ticks(from, until, unit.binary);
    return axis(label, unit, ticks.length ? ticks : [Math.sqrt(from * until)], { type: "logarithmic", min: from, max: until });
}

/* Lines from the least to the greatest run, and labels behind them. A dataset's spreads: {x, y} of its points, spreads both. */
const whiskers = {
    afterDatasetsDraw({ ctx, data: { datasets }, scales: { x, y }, options: { color } }) {
        const at = (scale, value, otherwise) => scale.getPixelForValue(scale.type !== "logarithmic" || value > 0 ? value : otherwise);
        ctx.save();
        ctx.font = "11px sans-serif";
        for (const { spreads = [], labels = [], colour = color } of datasets)
            for (const [n, spread] of spreads.entries()) {
                const left = at(x, spread.x.min, spread.x.median), middle = at(x, spread.x.median), right = at(x, spread.x.max);
                const low = at(y, spread.y.min, spread.y.median), height = at(y, spread.y.median), high = at(y, spread.y.max);
                ctx.strokeStyle = ctx.fillStyle = colour;
                ctx.beginPath();
                ctx.moveTo(left, height);
                ctx.lineTo(right, height);
                ctx.moveTo(middle, low);
                ctx.lineTo(middle, high);
                ctx.stroke();
                if (labels[n]) ctx.fillText(labels[n], right + 6, x.type === "linear" ? height + 4 : height - 5);
            }
        ctx.restore();
    },
};

const values_of = (points, axis) => points.flatMap((p) => [p[axis].min, p[axis].median, p[axis].max]).filter((value) => value > 0);

/* tell(point): its text at the mouse. Points of fitted lines have no cell and no text. */
const line_chart = (datasets, x, y, tell) => ({ type: "line", data: { datasets }, plugins: [whiskers],
    options: { scales: { x, y }, parsing: false, interaction: { mode: "nearest", intersect: true }, plugins: { legend: { display: false },
        tooltip: { filter: ({ raw }) => raw.cell, callbacks: { title: () => "", label: ({ raw }) => tell(raw) } } } } });

