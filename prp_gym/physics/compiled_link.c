/* N links, advanced one after the other with the function generated from the formula. */

#define PRP_PLANT 3
#define PRP_SURFACE 1

/* One time step; returns whether the link is lost. */
static inline int prp_substep(
    const prp_world *world, double *q, double *v, const double *tau, const double *plant, const double *surface)
{
    double later, faster;
    (void)world, (void)surface;
    prp_link_step(q, v, tau, plant, &later, &faster);
    if (!isfinite(later) || !isfinite(faster))
        return 1;
    *q = later, *v = faster;
    return 0;
}

/* See prp_advance of compiled_arm.c; measured: joint position, joint velocity. */
int prp_advance(
    long first, long count, const long *rows, const prp_world *world, double *restrict position,
    double *restrict velocity, const double *restrict torque, const double *restrict plants,
    const double *restrict surfaces, double *restrict measured, double *restrict beyond,
    unsigned char *restrict lost)
{
    int inside = 1;
    (void)beyond;
    for (long index = first; index < first + count; index++) {
        const long row = rows ? rows[index] : index;
        double *q = position + row, *v = velocity + row;
        for (int k = 0; k < world->substeps && !lost[row]; k++)
            lost[row] = prp_substep(world, q, v, torque + row, plants + PRP_PLANT * row, surfaces);
        lost[row] |= !(fabs(*q) <= world->bound[0] && fabs(*v) <= world->bound[1]);
        measured[2 * row] = *q, measured[2 * row + 1] = *v;
        inside &= !lost[row];
    }
    return inside;
}
