/* Tone mapping: exposure, light from the sky, a soft shoulder, the sRGB curve, the mean of samples x samples; also the linear
 * mean, without shoulder and curve. With fog it is drawn twice: linear, to `picture`; then, when fog is added to it, from there. */
layout(binding = 0) uniform sampler2D depths;
layout(binding = 1) uniform sampler2D normals;
layout(binding = 2) uniform sampler2D albedos;
layout(binding = 3) uniform sampler2D lights;
layout(binding = 4) uniform sampler2D picture;
uniform mat4 point_from_depth;
uniform vec4 sizes; /* width and height of the light, exposure, day: 1, or the factor on the sky's light at night */
uniform int samples;     /* 0: each sample on its own, linear */
uniform int has_picture; /* 1: what is shown is in `picture` */
layout(location = 0) out vec4 colour_out;
layout(location = 1) out vec4 linear_out;

const vec3 zenith = vec3(0.20, 0.40, 0.86), horizon = vec3(0.70, 0.81, 0.95), below = vec3(0.56, 0.61, 0.68), ground = vec3(0.30, 0.28, 0.25);

vec3 sky(float y)
{
    return y >= 0.0 ? mix(horizon, zenith, 1.0 - pow(1.0 - y, 2.5)) : mix(horizon, below, 1.0 - (1.0 + y) * (1.0 + y));
}

vec3 shown(ivec2 pixel)
{
    if (has_picture != 0) return texelFetch(picture, pixel, 0).rgb;
    float depth = texelFetch(depths, pixel, 0).r;
    vec4  way   = point_from_depth * vec4((vec2(pixel) + 0.5) / sizes.xy, depth, 1.0);
    if (depth == 0.0) return sizes.w * sky(normalize(way.xyz).y);
    vec3 ambient = 0.30 * sizes.w * mix(ground, mix(horizon, zenith, 0.5), 0.5 + 0.5 * texelFetch(normals, pixel, 0).y);
    return texelFetch(albedos, pixel, 0).rgb * (sizes.z * texelFetch(lights, pixel, 0).rgb + ambient);
}

float curve(float x)
{
    x = x < 0.6 ? x : 0.6 + 0.4 * (1.0 - exp(-(x - 0.6) / 0.4));
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055;
}

void main()
{
    linear_out = vec4(0.0);
    if (samples == 0) {
        colour_out = vec4(shown(ivec2(gl_FragCoord.xy)), 0.0); /* alpha: the share that smoke hides */
        return;
    }
    vec3 sum = vec3(0.0), light = vec3(0.0);
    for (int y = 0; y < samples; y++)
        for (int x = 0; x < samples; x++) {
            vec3 c = shown(ivec2(gl_FragCoord.xy) * samples + ivec2(x, y));
            sum += vec3(curve(c.r), curve(c.g), curve(c.b));
            light += c;
        }
    colour_out = vec4(sum / float(samples * samples), 1.0);
    linear_out = vec4(light / float(samples * samples), 1.0);
}
