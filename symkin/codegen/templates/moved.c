TABLE(weights, @nc, @weights)
name_real moved = reached ? 0.0 : HUGE_VAL;
EACH(i, @nc) {
    const name_real far = weights[i] * fabs(w.x[@begin + i] - answer[i]);
    moved = (far > moved) ? far : moved;
}
residual = (moved < residual) ? moved : residual;
