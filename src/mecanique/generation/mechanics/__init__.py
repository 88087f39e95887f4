"""Write the equations of motion on a tape: in closed form, or by recursion."""
