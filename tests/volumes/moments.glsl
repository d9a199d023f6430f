/* What part of a distribution on [-1, 1] lies above z, by its first four moments: of the distribution of three values that has them
 * and has z among them, all that is above, and half of what is at z: the middle of the least and the most that it can be. The other
 * two values are roots of the kernel polynomial of the moments; it and the weights are from the matrix of moments, as L D L^T. */
float part_above(vec4 moments, float z)
{
    const float BIAS = 3e-6; /* toward a distribution that is no single value, as far as floats need it */
    vec4  b   = mix(moments, vec4(0.0, 0.375, 0.0, 0.375), BIAS);
    float d1  = max(b.y - b.x * b.x, 1e-9), l = (b.z - b.x * b.y) / d1, d2 = max(b.w - b.y * b.y - l * l * d1, 1e-12);
    float y1  = z - b.x, y2 = (z * z - b.y - l * y1) / d2; /* forward, then back */
    float c2  = y2, c1 = y1 / d1 - l * c2, c0 = 1.0 - b.x * c1 - b.y * c2;
    float own = 1.0 / max(c0 + z * (c1 + z * c2), 1e-9);
    if (abs(c2) < 1e-9) return 1.0 - 0.5 * own;
    float half_sum = -0.5 * c1 / c2, root = sqrt(max(half_sum * half_sum - c0 / c2, 0.0));
    float low = half_sum - root, high = half_sum + root;
    float other = (b.y - b.x * (z + low) + z * low) / ((high - z) * (high - low)); /* the weight of `high` */
    float above = 0.5 * own;
    if (high > z) above += clamp(other, 0.0, 1.0);
    if (low > z) above += clamp(1.0 - own - other, 0.0, 1.0);
    return clamp(above, 0.0, 1.0);
}
