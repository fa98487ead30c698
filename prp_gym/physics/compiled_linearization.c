/* Linearisations of one simulation, by `prp_step_reverse` and `prp_measured_reverse` of its robot.

   Columns of a linearisation: joint position, joint velocity, torque. */

#define PRP_STATES (2 * PRP_AXES)
#define PRP_COLUMNS (3 * PRP_AXES)

/* Take one simulation over some time steps with constant torques, and the derivatives of the state after them
   by the state before and the torque, `derivative` (PRP_STATES, PRP_COLUMNS). Returns whether the simulation
   has stayed within its bounds. */
int prp_linearize(
    const prp_world *world, double *q, double *v, const double *tau, const double *plant, const double *surface,
    double *derivative)
{
    prp_world one = *world;
    double step[PRP_STATES][PRP_COLUMNS], total[PRP_STATES][PRP_COLUMNS] = {{0.0}};
    double measured[PRP_MOST_MEASURED], beyond[PRP_AXES];
    unsigned char lost = 0;
    one.substeps = 1;
    for (int i = 0; i < PRP_STATES; i++)
        total[i][i] = 1.0;
    for (int k = 0; k < world->substeps && !lost; k++) {
        for (int i = 0; i < PRP_STATES; i++) {
            double unit[PRP_STATES] = {0.0}, *row = step[i];
            unit[i] = 1.0;
            prp_step_reverse(
                world, q, v, tau, plant, surface, unit, unit + PRP_AXES, row, row + PRP_AXES, row + PRP_STATES);
        }
        for (int j = 0; j < PRP_COLUMNS; j++) {
            double column[PRP_STATES];
            for (int i = 0; i < PRP_STATES; i++) {
                column[i] = j < PRP_STATES ? 0.0 : step[i][j];
                for (int l = 0; l < PRP_STATES; l++)
                    column[i] += step[i][l] * total[l][j];
            }
            for (int i = 0; i < PRP_STATES; i++)
                total[i][j] = column[i];
        }
        prp_advance(0, 1, NULL, &one, q, v, tau, plant, surface, measured, beyond, &lost);
    }
    memcpy(derivative, total, sizeof total);
    return !lost;
}

/* The derivatives of the measurement by state and torque (width, PRP_COLUMNS). */
void prp_linearize_measurement(
    const prp_world *world, const double *q, const double *v, const double *tau, const double *plant,
    const double *surface, int width, double *derivative)
{
    for (int i = 0; i < width; i++) {
        double unit[PRP_MOST_MEASURED] = {0.0}, *row = derivative + PRP_COLUMNS * i;
        unit[i] = 1.0;
        prp_measured_reverse(
            world, q, v, tau, plant, surface, unit, row, row + PRP_AXES, row + PRP_STATES);
    }
}
