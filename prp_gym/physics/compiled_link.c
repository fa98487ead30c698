/* N links, advanced one after the other with the function generated from the formula. */

/* See prp_advance of compiled_arm.c; measured: joint position, joint velocity. */
int prp_advance(
    long first, long count, const long *rows, const prp_world *world, double *restrict position,
    double *restrict velocity, const double *restrict torque, const double *restrict plants,
    const double *restrict surfaces, double *restrict measured, double *restrict beyond,
    unsigned char *restrict lost)
{
    int inside = 1;
    (void)surfaces, (void)beyond;
    for (long index = first; index < first + count; index++) {
        const long row = rows ? rows[index] : index;
        double *q = position + row, *v = velocity + row, later, faster;
        for (int k = 0; k < world->substeps && !lost[row]; k++) {
            prp_link_step(q, v, torque + row, plants + 3 * row, &later, &faster);
            if (isfinite(later) && isfinite(faster))
                *q = later, *v = faster;
            lost[row] = *q != later;
        }
        lost[row] |= !(fabs(*q) <= world->bound[0] && fabs(*v) <= world->bound[1]);
        measured[2 * row] = *q, measured[2 * row + 1] = *v;
        inside &= !lost[row];
    }
    return inside;
}
