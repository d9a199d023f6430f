/* Axes of plots; see axis.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/page/axis.h"

#include <math.h>

#include "baker/page/html.h"
#include "baker/page/plot.h"

axis axis_of(axis_unit unit, int is_linear, const char *label)
{
    return (axis){unit, is_linear, label, INFINITY, -INFINITY};
}

void axis_add(axis *a, double value)
{
    if (!a->is_linear && !(value > 0)) return;
    if (value < a->min) a->min = value;
    if (value > a->max) a->max = value;
}

/* Without exponents, as people write them; noenhanced text, so plain characters. */
static void print_tic(FILE *to, axis_unit unit, double value)
{
    char text[32] = "0";
    switch (value == 0 ? UNIT_ZERO : unit) {
    case UNIT_ZERO: break;
    case UNIT_SECONDS: seconds_text(text, value); break;
    case UNIT_NANOSECONDS: seconds_text(text, value * 1e-9); break;
    case UNIT_SHARE: percent_text(text, value); break;
    case UNIT_BYTES:
        if (value < 1024)
            snprintf(text, sizeof text, "%g B", value);
        else if (value < 1024 * 1024)
            snprintf(text, sizeof text, "%g KiB", value / 1024);
        else if (value < 1024 * 1024 * 1024)
            snprintf(text, sizeof text, "%g MiB", value / (1024 * 1024));
        else
            snprintf(text, sizeof text, "%g GiB", value / (1024 * 1024 * 1024));
        break;
    case UNIT_COUNT:
        if (value < 1e3)
            snprintf(text, sizeof text, "%g", value);
        else if (value < 1e6)
            snprintf(text, sizeof text, "%g k", value / 1e3);
        else
            snprintf(text, sizeof text, "%g M", value / 1e6);
        break;
    case UNIT_TEXELS: snprintf(text, sizeof text, "%.0f", value); break;
    case UNIT_VOXELS:
        if (value <= MASKS_AT)
            snprintf(text, sizeof text, "masks");
        else
            snprintf(text, sizeof text, "%.0f³", value);
        break;
    }
    plot_tic(to, text, sizeof text, value);
}

enum { TICS_MAX = 6 };

/* Steps of 2^n on axes of bytes, texels and voxels, else 1, 2, 5, 10, as many as fit. */
static void print_log_tics(const axis *a, FILE *to, double from, double until)
{
    int         binary = a->unit == UNIT_BYTES || a->unit == UNIT_TEXELS || a->unit == UNIT_VOXELS, count = 0;
    const char *comma = "";
    if (binary) {
        int low = (int)ceil(log2(from) - 1e-9), high = (int)floor(log2(until) + 1e-9);
        int step = 1 + (high - low) / TICS_MAX;
        for (int n = low; n <= high; n += step, count++, comma = ", ") {
            fputs(comma, to);
            print_tic(to, a->unit, ldexp(1, n));
        }
    } else {
        int    low = (int)floor(log10(from)), high = (int)ceil(log10(until));
        double decades = log10(until / from);
        int    step    = decades > 8 ? 1 + (int)(decades / 8) : 1;
        for (int n = low; n <= high; n += step)
            for (int k = 0; k < 3; k++) {
                static const double digits[] = {1, 2, 5};
                double              value    = digits[k] * pow(10, n);
                if ((k && decades > 2.4) || value < from * 0.9999 || value > until * 1.0001) continue;
                fputs(comma, to);
                print_tic(to, a->unit, value);
                comma = ", ";
                count++;
            }
    }
    if (!count) print_tic(to, a->unit, sqrt(from * until));
}

static void print_linear_tics(const axis *a, FILE *to, double until)
{
    static const double steps[] = {1, 2, 5, 10};
    double              scale = a->unit == UNIT_BYTES ? pow(1024, floor(log2(until) / 10)) : 1, goal = until / scale / 5;
    double              power = pow(10, floor(log10(goal))), step = 10 * power;
    for (int n = 3; n >= 0; n--)
        if (steps[n] * power >= goal) step = steps[n] * power;
    for (double value = 0; value <= until / scale * 1.0001; value += step) {
        if (value > 0) fputs(", ", to);
        print_tic(to, a->unit, value * scale);
    }
}

void axis_print(const axis *a, FILE *to, char letter, double room)
{
    double from = a->min, until = a->max;
    if (from > until) from = 0.5, until = 1;
    if (a->is_linear) {
        if (!(until > 0)) until = 1;
        until *= 1.02 + room;
        fprintf(to, "set %crange [0:%.9g]\nset %ctics (", letter, until, letter);
        print_linear_tics(a, to, until);
    } else {
        double pad = fmax(1.12, pow(until / from, 0.06));
        if (until / from < 1.8) pad = 1.5; /* one point, or nearly */
        if (a->unit == UNIT_TEXELS || a->unit == UNIT_VOXELS) pad = fmin(fmax(pad, 1.2), 1.45);
        from /= pad;
        until *= pad * pow(until / from, room);
        fprintf(to, "set logscale %c\nset %crange [%.9g:%.9g]\nset %ctics (", letter, letter, from, until, letter);
        print_log_tics(a, to, from, until);
    }
    fprintf(to, ")\nset %clabel ", letter);
    plot_text(to, a->label, 80);
    fprintf(to, " textcolor rgb '" PLOT_SOFT "'\n");
}
