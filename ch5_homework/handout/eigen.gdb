# Two commands for gdb, since it shows the inside of Eigen's matrices:  matrix H,  vector b.  Load with gdb -x.
define matrix
  set $rows = $arg0.m_storage.m_rows
  set $i = 0
  while $i < $rows
    set $j = 0
    while $j < $arg0.m_storage.m_cols
      printf "%11.4g", $arg0.m_storage.m_data[$i + $j * $rows]
      set $j = $j + 1
    end
    printf "\n"
    set $i = $i + 1
  end
end
define vector
  print *$arg0.m_storage.m_data@$arg0.m_storage.m_rows
end
document matrix
Prints a MatXX, row by row.
end
document vector
Prints a VecX.
end
