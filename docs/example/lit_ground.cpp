/* Points on a walk through a level whose shadows stream in: how much of each light reaches the ground around them. C++11.
 *
 *     c++ lit_ground.cpp $(pkg-config --cflags --libs vxs) -o lit_ground
 *     ./lit_ground level.vxs 16         # within 16 MiB
 *
 * SPDX-License-Identifier: MIT */
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include <vxs.hpp>

namespace {

using point = std::array<double, 3>;

/* The mean over a square of ground, 16 x 16 points half a metre apart, and how many of them only the coarse level could answer. */
double lit_around(const vxs_baked_light &light, const point &middle_ws, int &coarse)
{
    const point up{{0, 1, 0}};
    double      sum = 0;
    for (int n = 0; n < 256; n++) {
        const point at_ws{{middle_ws[0] + (n % 16 - 7.5) / 2, middle_ws[1], middle_ws[2] + (n / 16 - 7.5) / 2}};
        const float lit = vxs_lookup(&light, at_ws.data(), up.data(), vxs_smooth(4));
        coarse += !vxs_lookup_is_full(&light, at_ws.data(), up.data(), vxs_smooth(4));
        sum += lit == VXS_OUTSIDE ? 0 : lit;
    }
    return sum / 256;
}

} // namespace

int main(int argc, char **argv)
{
    if (argc != 3) return std::fprintf(stderr, "usage: lit_ground LEVEL.vxs MIB\n"), 2;
    vxs_stream_desc desc = {};
    desc.struct_size     = sizeof desc;
    desc.path            = argv[1];
    desc.budget_bytes    = std::strtoull(argv[2], nullptr, 10) << 20;
    desc.threads         = 1;

    vxs::stream      stream; /* closed where it ends */
    const vxs_result result = vxs::open(stream, desc);
    if (result != VXS_OK) return std::fprintf(stderr, "lit_ground: %s: %s\n", argv[1], vxs_result_text(result)), 1;

    for (int step = -4; step <= 4; step++) {
        const point here_ws{{12.0 * step, 0.05, 0}};
        const auto  eye = vxs_stream_camera(here_ws.data(), 50);
        vxs_stream_frame(stream.get(), &eye, 1, nullptr); /* requests what is near, */
        vxs_stream_wait(stream.get());                    /* a game would draw meanwhile, */
        vxs_stream_frame(stream.get(), &eye, 1, nullptr); /* and what has come appears */
        std::printf("x = %3.0f m:", here_ws[0]);
        for (std::uint32_t n = 0; n < vxs_stream_light_count(stream.get()); n++) {
            const vxs_baked_light &light  = *vxs_stream_light(stream.get(), n);
            int                    coarse = 0;
            const double           lit    = lit_around(light, here_ws, coarse);
            std::printf("  %s %.1f %% lit%s", light.light.name, 100 * lit, coarse ? ", in part as the coarse level says" : "");
        }
        std::printf("\n");
    }
    return 0;
}
